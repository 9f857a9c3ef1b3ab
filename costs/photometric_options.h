// Options of the photometric energy.
#pragma once

#include "core/support/options.h"
#include "costs/occlusion_mask.h"

namespace burin {

struct PhotometricOptions {
  int window = 5;                 // taps along a side, odd
  double relative_floor = 0.1;    // e as a share of the photographs' contrast (costs/grey_units.h)
  double variance_floor = 0;      // e^2 in squared grey levels instead; 0 = by relative_floor
  double reliability = 0;         // nu = reliability * (noise_i^2 + noise_j^2), noise in units of e
  double min_valid_share = 0.8;   // of the window's taps
  bool double_precision = false;  // fields in double, for derivative checks
  MaskOptions mask;
  void Describe(OptionSet* set);
};

}  // namespace burin
