#include "core/mesh/remesh.h"

#include <glog/logging.h>

#include "core/mesh/remesh_steps.h"

namespace burin {
namespace {

// The last rounds place vertices by planes and flip for shape.
constexpr int kFinishingRounds = 2;
constexpr double kSliverQuality = 0.5;  // its smallest angle is some 16 degrees

}  // namespace

Remeshed Remesh(const TriangleMesh& mesh, const std::vector<double>& edge_length,
                const RemeshOptions& options, const std::vector<char>* keep) {
  CHECK_EQ(edge_length.size(), mesh.vertices.size());
  for (const double length : edge_length) CHECK_GT(length, 0);
  if (keep != nullptr) CHECK_EQ(keep->size(), mesh.faces.size());
  RemeshState state(mesh, edge_length, keep);
  int splits = 0;
  int collapses = 0;
  int flips = 0;
  for (int k = 0; k < options.iterations; ++k) {
    splits += SplitLongEdges(&state);
    collapses += CollapseShortEdges(&state);
    flips += FlipEdges(&state, FlipFor::kValence);
    if (k == 0) state.Compact();
    Relax(&state, 2 * k < options.iterations ? RelaxOn::kSurface : RelaxOn::kPlanes);
  }
  for (int k = 0; k < kFinishingRounds; ++k) {
    flips += FlipEdges(&state, FlipFor::kQuality);
    collapses += CollapseSlivers(&state, kSliverQuality);
    Relax(&state, RelaxOn::kPlanes);
  }
  flips += FlipEdges(&state, FlipFor::kQuality);
  Remeshed result = state.Take();
  result.split_count = splits;
  result.collapse_count = collapses;
  result.flip_count = flips;
  return result;
}

}  // namespace burin
