// How far the sparse points are from where structure from motion measured them. It ends with medians of .2 to
// .5 px on pictures of 1500 to 3000 px. Cameras that do not belong to the points are off by far more: one with
// the pose of its neighbour, some degrees on around a flat thing, by 1.2 % of the picture's longer side and up.
#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace burin {

// What a view may be off by: the smaller of both.
constexpr double kMostTrackErrorPx = 16;
constexpr double kMostTrackErrorShare = 0.01;  // of its longer side

struct TrackErrors {
  // By view, in pixels: the median over its measurements; those of points behind the camera count as
  // infinite. NaN for fewer than 10 measurements.
  std::vector<double> median_px;
  int known = 0;         // views that have one
  std::vector<int> off;  // those that are off by more than they may be, worst first

  // In more than half of the views that are known.
  bool MostAreOff() const { return 2 * static_cast<int>(off.size()) > known; }
};

TrackErrors MeasureTrackErrors(const Scene& scene);

}  // namespace burin
