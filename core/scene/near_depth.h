// Where a view begins to see: well before the nearest points that structure from motion measured in it.
#pragma once

#include "core/scene/scene.h"

namespace burin {

// Sets Camera::near_depth of every view with at least 50 points in front of it to a twentieth of the depth that one
// per cent of them are nearer than. A mesh that has surface there, a wall behind the photographer or a sheet
// that a reconstruction drew through the cameras, would hide the view, and be cut into facets of its pixels.
// Views whose points are not where they were measured (track_errors.h) have none.
void SetNearDepths(Scene* scene);

}  // namespace burin
