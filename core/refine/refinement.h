// The coarse-to-fine loop: levels of the image pyramid (core/refine/level.h), on each the mesh is cut to
// the level's pixels, then rounds of freezing visibility and minimising the sum of the energy terms.
//
// Everything runs in the normalised world (core/refine/normalized_world.h).
//
// Every level gets more rounds than the next finer one, and a finer tolerance than the finest. What
// is many pixels off - a facet that bridges a depth step, a niche that the initial mesh covers - can
// only move there, within the few pixels over which windows correlate, and moves far only when
// visibility is frozen anew on the way; the rest of the mesh has converged by then and the sum's
// relative tolerance no longer notices. A level has a quarter of the pixels of the next, so this
// costs little. Views whose images have less than min_side_px take no part in a level
// (core/refine/view_levels.h): smoothness, which does not shrink with the pixels, would be all there is.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/refine/refinement_options.h"
#include "core/refine/refinement_parts.h"
#include "core/refine/refinement_state.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

// Moves (and adds) vertices of `input` so that the sum of the terms falls.
// With `start`, a state that on_state was given by a refinement of the same scene, mesh, pairs,
// options and terms, it goes on from there and comes to the same bytes; seconds in the summary are
// summed over both. Throws InputError when the pairs see nothing of the mesh or an option does not
// fit the data.
TriangleMesh Refine(const Scene& scene, const TriangleMesh& input,
                    const std::vector<CameraPair>& pairs, const RefinementOptions& options,
                    const RefinementParts& parts, const RefinementObservers& observers,
                    RefinementSummary* summary, const RefinementState* start = nullptr);

}  // namespace burin
