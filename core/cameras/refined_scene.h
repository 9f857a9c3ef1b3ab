// A scene through refined cameras.
#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace burin {

// `scene` with these cameras of its views; sparse points that have measurements are where these put them, one pixel being the scale of
// the robust loss. A point that they put nowhere stays, and so do all where the
// cameras are the scene's. Pixels are shared.
Scene WithRefinedCameras(const Scene& scene, const std::vector<Camera>& cameras);

}  // namespace burin
