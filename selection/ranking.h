// Picks the best partners of each view from a score for every ordered pair of views.
#pragma once

#include <algorithm>
#include <vector>

#include "core/scene/pairs.h"

namespace burin {

// For each of `view_count` views i the `per_camera` partners j with the highest positive score
// scores[i * view_count + j], best first, ties by lower index.
template <typename Score>
std::vector<CameraPair> BestPartners(const std::vector<Score>& scores, int view_count,
                                     int per_camera) {
  std::vector<CameraPair> pairs;
  std::vector<int> order(view_count);
  for (int i = 0; i < view_count; ++i) {
    const Score* row = scores.data() + static_cast<size_t>(i) * view_count;
    for (int j = 0; j < view_count; ++j) order[j] = j;
    std::stable_sort(order.begin(), order.end(), [row](int a, int b) { return row[a] > row[b]; });
    for (int k = 0; k < per_camera && k < view_count && row[order[k]] > Score(0); ++k) {
      pairs.push_back({i, order[k]});
    }
  }
  return pairs;
}

}  // namespace burin
