// Draws together what a refinement has folded out of sight.
//
// A facet that bridges a depth step is pulled to the step from both sides, and what is left of it
// ends up behind the silhouette, in a fold that no pair sees. Nothing there holds it any more: it
// is no evidence of a surface, nor the input's shape, but it is area, often ragged, and in the way
// of later rounds.
#pragma once

#include "core/mesh/mesh.h"
#include "core/solve/energy_term.h"

namespace burin {

// Moves every vertex that a pair saw in an earlier round and none sees now (it is not seen and not supported, but moves:
// core/refine/support.h) to the mean of its neighbours, `sweeps` times, all at once in each: the folds tend to
// the membrane over their rims. Vertices on an open border take the mean of their neighbours along
// it. All others stay where they are, and so do parts that hang on none of them, which would shrink
// to a point. Returns the number of vertices moved. `context` may be that of before a solve: its
// neighbours, `seen`, `supported` and `moves` are used, no positions.
int RelaxHiddenFolds(const RoundContext& context, int sweeps, TriangleMesh* mesh);

}  // namespace burin
