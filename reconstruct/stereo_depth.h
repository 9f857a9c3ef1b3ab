// Depth of a view's pixels, matched with its partners by semi-global matching (Hirschmueller, PAMI 2008; OpenCV's
// StereoSGBM with three paths).
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/scene/scene.h"

namespace burin {

// By pixel of the view; 0 where nothing is known.
struct DepthMap {
  cv::Mat1f depth;  // camera z, world units
  cv::Mat1f sigma;  // the change of depth for one pixel of disparity, world units
};

// Of one pair; empty where the pair cannot be rectified. `points`: sparse points that the first view sees.
DepthMap MatchPair(const View& first, const View& second,
                   const std::vector<Eigen::Vector3d>& points);

struct FusedDepth {
  DepthMap map;
  cv::Mat1i pairs;            // bit k: partner k agrees
  std::vector<int> partners;  // views, by bit
};

// At each pixel the depth that most pairs agree on, within one pixel of disparity of the less certain: their mean by
// 1 / sigma^2. At least `least` pairs; pixels off the view's mask have none. Maps may be empty; so is the result where
// all are. The partners are left to the caller.
FusedDepth FusePairs(const std::vector<DepthMap>& pairs, const cv::Mat& mask, int least);

}  // namespace burin
