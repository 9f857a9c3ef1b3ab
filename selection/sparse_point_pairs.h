// Camera pairs from sparse points, as methods before the paper choose them. Each camera gets the partners
// with which it shares the most points under a parallax in a given range (Vu et al. 2012 as the paper
// quotes it; `vu` uses 20 to 60 degrees).
#pragma once

#include <vector>

#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

// Number of points seen by both views under an angle at the point in [min_deg, max_deg].
// Entry (i, j) of the row-major views x views result; symmetric, zero diagonal.
std::vector<int> CommonPointCounts(const Scene& scene, double min_deg, double max_deg);

// For each view the `per_camera` best partners by CommonPointCounts, most first, ties by lower
// index. A view that shares no such point with any other gets no pair.
std::vector<CameraPair> SparsePointPairs(const Scene& scene, int per_camera, double min_deg,
                                         double max_deg);

}  // namespace burin
