#include "core/refine/facet_texture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kRadius = 2;
constexpr double kTimesNoise = 1.5;
constexpr double kOfContrast = 0.02;
constexpr double kSpacingPx = 2 * kRadius + 1;
constexpr int kMostSteps = 64;  // of points along a side
constexpr double kSurroundings = 2;

}  // namespace

cv::Mat1b TexturedPixels(const cv::Mat& image, double least_deviation) {
  const cv::Size window(2 * kRadius + 1, 2 * kRadius + 1);
  cv::Mat1d mean;
  cv::Mat1d square;
  cv::boxFilter(image, mean, CV_64F, window);
  cv::sqrBoxFilter(image, square, CV_64F, window);
  cv::Mat1b textured = square - mean.mul(mean) >= least_deviation * least_deviation;
  cv::Mat1b inside(image.size(), uchar{0});
  if (image.rows > 2 * kRadius && image.cols > 2 * kRadius) {
    const cv::Rect whole_windows(kRadius, kRadius, image.cols - 2 * kRadius,
                                 image.rows - 2 * kRadius);
    textured(whole_windows).copyTo(inside(whole_windows));
  }
  return inside;
}

FacetTexture::FacetTexture(const std::vector<LevelView>& views, const TriangleMesh& mesh)
    : views_(views), rays_(mesh), textured_(views.size()) {
  for (const LevelView& view : views) centers_.push_back(view.camera.Center());
  ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (!views[i].at.takes_part) continue;
      const double least =
          std::max(kTimesNoise * views[i].noise_sigma, kOfContrast * views[i].contrast);
      textured_[i] = TexturedPixels(views[i].image, least);
    }
  });
}

bool FacetTexture::IsTextured(int view, const Eigen::Vector3d& point) const {
  const Camera& camera = views_[view].camera;
  if (camera.Depth(point) <= camera.near_depth) return false;
  const Eigen::Vector2d at = camera.Project(point);
  if (!camera.Contains(at)) return false;
  return textured_[view](static_cast<int>(at.y()), static_cast<int>(at.x())) != 0;
}

bool FacetTexture::InTwoViews(const Eigen::Vector3d& facet_a, const Eigen::Vector3d& facet_b,
                              const Eigen::Vector3d& facet_c) const {
  const Eigen::Vector3d middle = (facet_a + facet_b + facet_c) / 3;
  const Eigen::Vector3d a = middle + kSurroundings * (facet_a - middle);
  const Eigen::Vector3d b = middle + kSurroundings * (facet_b - middle);
  const Eigen::Vector3d c = middle + kSurroundings * (facet_c - middle);
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  std::vector<int> facing;
  double footprint = 0;  // the smallest
  for (size_t i = 0; i < views_.size(); ++i) {
    if (!views_[i].at.takes_part || normal.dot(centers_[i] - a) <= 0) continue;
    facing.push_back(static_cast<int>(i));
    const double here = views_[i].camera.Footprint(middle);
    if (here > 0 && (footprint == 0 || here < footprint)) footprint = here;
  }
  if (facing.size() < 2 || footprint == 0) return facing.size() >= 2;
  const auto in_two_views = [&](const Eigen::Vector3d& point) {
    int textured = 0;
    for (const int view : facing) {
      if (!IsTextured(view, point) || !rays_.Sees(views_[view].camera, point, normal)) continue;
      if (++textured == 2) return true;
    }
    return false;
  };
  if (in_two_views(middle)) return true;  // most
  const int steps =
      std::clamp(static_cast<int>(std::ceil(std::min(longest / (kSpacingPx * footprint), 1e6))), 1,
                 kMostSteps);
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; i + j < steps; ++j) {
      const double u = (i + 1.0 / 3) / steps;
      const double v = (j + 1.0 / 3) / steps;
      if (in_two_views(a + u * (b - a) + v * (c - a))) return true;
    }
  }
  return false;
}

}  // namespace burin
