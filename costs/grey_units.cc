#include "costs/grey_units.h"

#include <algorithm>
#include <cmath>

namespace burin {
namespace {

constexpr double kFloorPerNoise = 1.5;

}  // namespace

GreyUnits UnitsOf(const LevelView& view, const PhotometricOptions& options) {
  GreyUnits units;
  units.offset = view.mask.empty() ? cv::mean(view.image)[0] : cv::mean(view.image, view.mask)[0];
  if (options.variance_floor > 0) {
    units.unit = std::sqrt(options.variance_floor);
    return units;
  }
  const double floor =
      std::max(options.relative_floor * view.contrast, kFloorPerNoise * view.photo_noise_sigma);
  if (floor > 0) units.unit = floor;
  return units;
}

}  // namespace burin
