// The units that the photometric energy measures a photograph's grey levels in: so that neither the
// exposure of a photograph nor the range its file stores it in changes the energy.
#pragma once

#include "core/scene/pyramid.h"
#include "costs/photometric_options.h"

namespace burin {

// I' = (I - offset) / unit.
struct GreyUnits {
  double offset = 0;  // the mean: keeps the squares in the window sums small in single precision
  double unit = 1;    // grey levels, > 0: e_i, the standard deviation of the variance floor
};

// e_i = sqrt(photo.variance_floor) where that is given, and else the larger of photo.relative_floor
// times the photographs' contrast and 1.5 times the view's noise; 1 for photographs that have neither.
GreyUnits UnitsOf(const LevelView& view, const PhotometricOptions& options);

}  // namespace burin
