// Two views turned so that what both see lies on the same row: where to sample them, and what disparities mean.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/scene/camera.h"

namespace burin {

// With x along the baseline from the first centre to the second, a world point X is at column
// focal p.x / p.z + shift of each picture, p = rotation (X - centre), and at row focal p.y / p.z + row_shift of both:
// array elements, the first at 0. Its disparity is the column in the first less that in the second.
struct RectifiedPair {
  Eigen::Matrix3d rotation;  // of rectified_from_world
  double focal = 0;          // pixels
  double baseline = 0;       // world units
  double shift[2] = {};
  double row_shift = 0;
  int width = 0;
  int height = 0;
  int min_disparity = 0;
  int disparity_count = 0;  // a multiple of 16

  // Inverse of the depth along the rectified axis, from a disparity.
  double InverseDepth(double disparity) const {
    return (disparity - shift[0] + shift[1]) / (focal * baseline);
  }
  // Where the pixels of picture 0 or 1 are in the view's array, CV_32FC2.
  cv::Mat2f SamplePlaces(int picture, const Camera& camera) const;
};

// Pictures that hold what `points` (seen by the first view) span in both views, and disparities from them: the .3 to
// 99.7 % quantiles and .15 of their distance. Nothing where few points are in front of both, and for a baseline so near to
// the line of sight that the pictures would be far larger than the views.
std::optional<RectifiedPair> Rectify(const Camera& first, const Camera& second,
                                     const std::vector<Eigen::Vector3d>& points);

}  // namespace burin
