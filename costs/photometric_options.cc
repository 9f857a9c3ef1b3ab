#include "costs/photometric_options.h"

namespace burin {

void PhotometricOptions::Describe(OptionSet* set) {
  set->Add("photo.window", &window, "Taps along a side of the correlation window; odd", 3, 31);
  set->Add(
      "photo.relative_floor", &relative_floor,
      "Standard deviation added to every window, as a share of the photographs' contrast: flat "
      "windows lose weight",
      1e-6, 1e3);
  set->Add(
      "photo.variance_floor", &variance_floor,
      "Variance added to every window instead, in squared grey levels (0 to 255), alike in all "
      "photographs; 0 = by photo.relative_floor",
      0, 1e6);
  set->Add("photo.reliability", &reliability,
           "Weight windows by s^2/(s^2 + n * reliability * noise^2); 0 = all alike", 0, 1e6);
  set->Add("photo.min_valid_share", &min_valid_share,
           "Windows with a smaller share of valid taps are left out", 0, 1);
  set->Add("photo.double_precision", &double_precision,
           "Pixel fields in double precision (slower; for derivative checks)");
  mask.Describe(set);
}

}  // namespace burin
