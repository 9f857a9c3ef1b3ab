// Which views are matched with which, to see depth.
#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace burin {

struct StereoRules {
  int partners = 4;  // of a view, at most
  // Median over the sparse points that both see of the angle between their lines of sight. Below, depth is noise; above,
  // scanlines do not match.
  double min_angle_deg = 4;
  double max_angle_deg = 25;
  double best_angle_deg = 12;
};

// By view, its partners, the best first: n exp(-(ln(angle / best) / .5)^2 / 2) with n points that both see. Pairs that see
// fewer than 20 together are none.
std::vector<std::vector<int>> ChooseStereoPartners(const Scene& scene, const StereoRules& rules);

}  // namespace burin
