// What a list of distances comes to: the figures every protocol of core/ reports.
#pragma once

#include <cstdint>
#include <vector>

namespace burin {

// Of distances, world units.
struct DistanceStatistics {
  std::int64_t count = 0;    // points asked
  std::int64_t matched = 0;  // those with a match in reach; the rest is over these, NaN without any
  double mean = 0;
  double median = 0;  // the lower of the two middle ones when their number is even
  double rmse = 0;
  double MatchedShare() const {
    return count > 0 ? static_cast<double>(matched) / static_cast<double>(count) : 0;
  }
};

// One distance per point asked; negative where the point has no match.
DistanceStatistics StatisticsOf(const std::vector<double>& distances);

}  // namespace burin
