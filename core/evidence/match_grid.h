// ZNCC of a window of one image on a grid of places in another: the innermost part of
// core/evidence/window_matches.h.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "core/evidence/window_matches.h"

namespace burin {

constexpr int kWindowRadius = 5;
constexpr int kWindowSide = 2 * kWindowRadius + 1;
constexpr int kGridRows = 2 * kMatchAcross + 1;
constexpr int kPeakReach = 3;  // a peak's own slopes
constexpr int kGridColumns = 2 * kMatchAlong + 1;

// An image point and the steps, in pixels, to its neighbours on the grid.
struct SampleGrid {
  Eigen::Vector2d center;
  Eigen::Vector2d along;
  Eigen::Vector2d across;
  Eigen::Vector2d At(int a, int b) const { return center + a * along + b * across; }
};

// ZNCC by place, across and along; 0 where a window is constant.
using GridScores = std::array<std::array<float, kGridColumns>, kGridRows>;

struct GridPeak {
  float score = 0;
  float second = 0;  // best score more than kPeakReach from it along or across
  int row = 0;       // from the middle
  double along = 0;  // of the paraboloid through the neighbours, from the middle
  double across = 0;
  bool inside = false;  // not on the rim, where the true peak may be outside
};

GridPeak PeakOf(const GridScores& scores);

// The four pixels around an image point are in the image.
bool InsideForSampling(const cv::Mat1f& image, const Eigen::Vector2d& at);

class GridWindow {
 public:
  // The kWindowSide^2 samples around grid.center.
  GridWindow(const cv::Mat1f& image, const SampleGrid& grid);

  bool valid() const { return valid_; }          // all samples are in the image
  double contrast() const { return contrast_; }  // standard deviation, grey levels

  // Nothing where a sample would be outside the image.
  std::optional<float> ScoreAt(const cv::Mat1f& image, const SampleGrid& grid) const;
  std::optional<GridScores> ScoresAround(const cv::Mat1f& image, const SampleGrid& grid) const;

 private:
  std::array<std::array<float, kWindowSide>, kWindowSide> unit_ = {};  // mean 0, sum of squares 1
  double contrast_ = 0;
  bool valid_ = false;
};

}  // namespace burin
