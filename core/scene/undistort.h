// Takes lens distortion out of an image, so that a pinhole camera describes it.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "core/scene/camera.h"

namespace burin {

// How a lens moves the undistorted normalised point (u, v), r^2 = u^2 + v^2.
struct Lens {
  // Brown-Conrady coefficients k1, k2, p1, p2, k3 in OpenCV's order and sign: photographed at
  //   u' = u (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 u v + p2 (r^2 + 2 u^2)
  //   v' = v (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p2 u v + p1 (r^2 + 2 v^2).
  std::array<double, 5> brown = {0, 0, 0, 0, 0};
  // The other way round, from the photograph (VisualSFM): (u, v) = (u', v') (1 + measured r'^2). Where
  // it is not 0 the others are.
  double measured = 0;
  bool IsNone() const { return brown == std::array<double, 5>{0, 0, 0, 0, 0} && measured == 0; }
};

// The image that `camera` sees, from one with the same size and intrinsics seen through the lens.
// Sampled with Catmull-Rom cubics at unrounded positions (OpenCV's own remapping rounds them to
// 1/32 pixel, and its cubic kernel shifts edges by up to 0.05). Pixels that the lens put outside
// the photograph repeat its border. `gray` is CV_8UC1 or CV_32FC1, and so is the result.
cv::Mat Undistort(const cv::Mat& gray, const Camera& camera, const Lens& lens);

// Which pixels of that image were photographed: CV_8UC1, 255 where the lens puts the pixel's centre into
// the photograph, 0 where it puts it outside and from the radius on where it folds back (where the
// distance from the principal point in the photograph, tangential part left out, no longer grows).
cv::Mat PhotographedPixels(const Camera& camera, const Lens& lens);

// The normalised radius of the picture's corner that is farthest from the principal point.
double CornerRadius(const Camera& camera);

// The undistorted radius, in normalised coordinates below `largest`, at which the lens folds back; else
// `largest`.
double FoldRadius(const Lens& lens, double largest);

}  // namespace burin
