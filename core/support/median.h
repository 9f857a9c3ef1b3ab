// The median of numbers.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

namespace burin {

// The upper one of the two in the middle where there are two; NaN when there is none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Standard deviation of normal numbers, from the median of their magnitudes: 1 / Phi^-1(3/4).
constexpr double kSigmaOfMedian = 1.4826;

}  // namespace burin
