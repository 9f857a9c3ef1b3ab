// The cheapest division of the cells of a triangulation into outside (source) and inside (sink).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reconstruct/triangulation.h"

namespace burin {

// What a division costs, in whole numbers, so that sums and the cut do not depend on any order.
struct CutCosts {
  explicit CutCosts(int cells) : facet(cells), outside(cells, 0), must_be_outside(cells, 0) {}

  // facet[c][k]: where c is outside and its neighbour across facet k inside.
  std::vector<std::array<std::int32_t, 4>> facet;
  std::vector<std::int32_t> outside;  // where the cell is outside
  std::vector<char> must_be_outside;
};

// By cell, whether it is inside. Of equally cheap divisions the one with the fewest cells outside: those that the
// source reaches in the residual graph of any maximum flow. Boykov and Kolmogorov's algorithm (PAMI 2004), from their
// library, which is under the GPL and in this file only.
std::vector<char> MinimumCut(const Tetrahedra& tetrahedra, const CutCosts& costs);

}  // namespace burin
