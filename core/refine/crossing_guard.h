// Takes back what a round pushes through another part of the surface.
//
// A pair of facets that cross (core/mesh/crossings.h) after a round is new when neither of them crossed anything
// before it: what crosses already may untangle. The vertices of new pairs, and those one ring around, go half of the
// way that the round moved them, then a quarter, an eighth, and then none of it, until no pair is new. What goes back
// can meet what moved on, so vertices are added on the way; the number of turns is bounded, and what is left is
// reported.
//
// Not all that crosses is a sheet that comes through another. Facets that look the same way are wrinkles of a doubled
// surface: they do not count. Bridges over depth steps fold away on purpose, through themselves: pairs that lie within
// some rings of each other do not count where every vertex is seen by some pair of views, or one is on its way out of
// sight (core/refine/hidden_folds.h).
#pragma once

#include <vector>

#include "core/mesh/crossings.h"
#include "core/mesh/mesh.h"
#include "core/solve/energy_term.h"

namespace burin {

struct CrossingReport {
  int found = 0;       // new pairs that the round made
  int left = 0;        // of them and of those that taking back made, in the end
  int taken_back = 0;  // vertices that go less than all of their way
};

// The pairs of a mesh that cross, round by round of a level.
class CrossingGuard {
 public:
  explicit CrossingGuard(const TriangleMesh& mesh) : pairs_(CrossingFacets(mesh)) {}

  // `mesh` has come from `before`, the positions that the guard saw last, by the round of `context`. Without
  // `take_back` it is only looked at.
  CrossingReport EndRound(const std::vector<Eigen::Vector3d>& before, const RoundContext& context,
                          bool take_back, TriangleMesh* mesh);

  // Facets that cross another one, as the guard saw the mesh last.
  int Facets() const { return CountFacets(pairs_); }

 private:
  std::vector<FacetPair> pairs_;
};

}  // namespace burin
