// The measures of a pair, summed over surface points.
#pragma once

#include <cstdint>

#include "selection/pair_terms.h"

namespace burin {

// Degrees, inclusive: what PairMeasure::area_in_range counts.
struct ParallaxRange {
  double min_deg = 0;
  double max_deg = 180;
};

class PairSums {
 public:
  // A point as views i and j see it.
  void Add(const PointSight& i, const PointSight& j, const ParallaxRange& range);

  // Over the points added, of `image_points` that view i's image has. Without points nothing is shared.
  PairMeasure Mean(double image_points) const;

 private:
  int64_t count_ = 0;
  int64_t in_range_ = 0;
  PairMeasure sum_;  // without its areas
};

}  // namespace burin
