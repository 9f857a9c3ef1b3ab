#include "selection/pair_sums.h"

#include <cmath>

namespace burin {

void PairSums::Add(const PointSight& i, const PointSight& j, const ParallaxRange& range) {
  const double parallax = ParallaxDeg(i, j);
  ++count_;
  if (parallax >= range.min_deg && parallax <= range.max_deg) ++in_range_;
  sum_.parallax_deg += parallax;
  for (const int form : {0, 1}) {
    const double difference = OrientedAngleDifferenceDeg(i, j, form == 1);
    sum_.symmetry_deg[form][0] += std::abs(difference);
    sum_.symmetry_deg[form][1] += difference;
  }
  sum_.resolution += ResolutionDiscrepancy(i, j, false);
  sum_.resolution_printed += ResolutionDiscrepancy(i, j, true);
}

PairMeasure PairSums::Mean(double image_points) const {
  PairMeasure mean;
  if (count_ == 0) return mean;
  const auto points = static_cast<double>(count_);
  mean.area = points / image_points;
  mean.area_in_range = static_cast<double>(in_range_) / image_points;
  mean.parallax_deg = sum_.parallax_deg / points;
  for (const int form : {0, 1}) {
    for (const int kind : {0, 1}) {
      mean.symmetry_deg[form][kind] = sum_.symmetry_deg[form][kind] / points;
    }
  }
  mean.resolution = sum_.resolution / points;
  mean.resolution_printed = sum_.resolution_printed / points;
  return mean;
}

}  // namespace burin
