// The small synthetic scene that whole refinements are tested on: relief at 240x180, seconds to refine.
#pragma once

#include "core/synthetic/synthetic.h"

namespace burin::test {

inline SyntheticOptions SmallReliefOptions(int views) {
  SyntheticOptions options;
  options.views = views;
  options.width = 240;
  options.height = 180;
  options.samples_per_axis = 2;
  options.init_edge_px = 24;
  options.relief_px = 3;
  options.truth_point_count = 1000;
  options.point_count = 500;
  return options;
}

}  // namespace burin::test
