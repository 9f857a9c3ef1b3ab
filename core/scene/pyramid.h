// The views of a scene at one level of the coarse-to-fine loop.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace burin {

// A view at one level of the pyramid, in the normalised world (see core/refine/refinement.h).
struct LevelView {
  Camera camera;
  cv::Mat image;           // grey levels 0..255, CV_8UC1 or CV_32FC1
  cv::Mat mask;            // CV_8UC1, 0 = not to be used; empty = all pixels are
  double noise_sigma = 0;  // estimated standard deviation of the image noise, grey levels

  // The image in single precision; a copy unless it is already.
  cv::Mat1f FloatImage() const {
    cv::Mat1f result;
    image.convertTo(result, CV_32F);
    return result;
  }
};

// Images area-averaged to 2^-level of their size (at least 16 pixels a side) with matching cameras,
// in the world mapped by X -> scale * (X - origin). Level 0 keeps the size. A pixel of a level is
// used when the mask allows every pixel that it is made of, and those around them: a masked pixel
// must not reach a sample through interpolation.
std::vector<LevelView> MakeLevelViews(const Scene& scene, int level, const Eigen::Vector3d& origin,
                                      double scale);

// Standard deviation of an image's noise in grey levels. The noise-only response of the mask
// [1 -2 1; -2 4 -2; 1 -2 1] has 6 times the noise's standard deviation (Immerkaer, "Fast noise
// variance estimation", 1996); taken as the 20th percentile over 16x16 blocks that are neither
// saturated nor constant, so that texture does not count as noise. 0 when there is no such block.
double EstimateNoise(const cv::Mat1f& image);

}  // namespace burin
