// Points from depth maps: where two views' depths agree, thinned to an even spacing in the pictures.
#pragma once

#include <functional>
#include <vector>

#include "core/scene/scene.h"
#include "reconstruct/sighted_points.h"
#include "reconstruct/stereo_depth.h"

namespace burin {

struct DenseRules {
  int spacing_px = 8;
  int confirming_views = 1;  // whose own depth must agree, beside the view's own
};

// Adds to `points` one point for each square of spacing_px of each view in which none of them is yet: where most pairs
// agree. Views with more depths come first. A point is seen by its view, by the partners that agree, and by
// the views whose depth agrees within 1.5 sqrt(2) of the larger sigma.
void AddDensePoints(const Scene& scene, const std::vector<FusedDepth>& depths,
                    const DenseRules& rules, SightedPoints* points);

}  // namespace burin
