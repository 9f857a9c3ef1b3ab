#include "core/support/distance_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace burin {

DistanceStatistics StatisticsOf(const std::vector<double>& distances) {
  DistanceStatistics statistics;
  statistics.count = static_cast<std::int64_t>(distances.size());
  std::vector<double> matched;
  matched.reserve(distances.size());
  double sum = 0;
  double squares = 0;
  for (const double distance : distances) {
    if (distance < 0) continue;
    matched.push_back(distance);
    sum += distance;
    squares += distance * distance;
  }
  statistics.matched = static_cast<std::int64_t>(matched.size());
  if (matched.empty()) {
    statistics.mean = statistics.median = statistics.rmse =
        std::numeric_limits<double>::quiet_NaN();
    return statistics;
  }
  statistics.mean = sum / static_cast<double>(matched.size());
  statistics.rmse = std::sqrt(squares / static_cast<double>(matched.size()));
  const auto middle = matched.begin() + (matched.size() - 1) / 2;
  std::nth_element(matched.begin(), middle, matched.end());
  statistics.median = *middle;
  return statistics;
}

}  // namespace burin
