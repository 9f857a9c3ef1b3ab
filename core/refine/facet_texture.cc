#include "core/refine/facet_texture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

constexpr int kRadius = 2;
constexpr int kTaps = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr double kTimesNoise = 1.5;
constexpr double kOfContrast = 0.02;
constexpr double kSpacingPx = 2 * kRadius + 1;
constexpr int kMostSteps = 64;  // of points along a side

double Level(const cv::Mat& image, int x, int y) {
  return image.depth() == CV_8U ? image.at<uchar>(y, x) : image.at<float>(y, x);
}

}  // namespace

FacetTexture::FacetTexture(const std::vector<LevelView>& views, const TriangleMesh& mesh)
    : views_(views), rays_(mesh) {
  for (const LevelView& view : views) {
    centers_.push_back(view.camera.Center());
    const double least = std::max(kTimesNoise * view.noise_sigma, kOfContrast * view.contrast);
    least_variance_.push_back(least * least);
  }
}

bool FacetTexture::IsTextured(int view, const Eigen::Vector3d& point) const {
  const Camera& camera = views_[view].camera;
  if (camera.Depth(point) <= camera.near_depth) return false;
  const Eigen::Vector2d at = camera.Project(point);
  if (!camera.Contains(at)) return false;
  const int x = static_cast<int>(at.x());
  const int y = static_cast<int>(at.y());
  if (x < kRadius || y < kRadius || x + kRadius >= camera.width || y + kRadius >= camera.height) {
    return false;
  }
  double sum = 0;
  double squares = 0;
  for (int v = y - kRadius; v <= y + kRadius; ++v) {
    for (int u = x - kRadius; u <= x + kRadius; ++u) {
      const double level = Level(views_[view].image, u, v);
      sum += level;
      squares += level * level;
    }
  }
  return squares / kTaps - (sum / kTaps) * (sum / kTaps) >= least_variance_[view];
}

bool FacetTexture::InTwoViews(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c) const {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const Eigen::Vector3d middle = (a + b + c) / 3;
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
  const int steps =
      std::clamp(static_cast<int>(std::ceil(std::min(longest / (kSpacingPx * footprint), 1e6))), 1,
                 kMostSteps);
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; i + j < steps; ++j) {
      const double u = (i + 1.0 / 3) / steps;
      const double v = (j + 1.0 / 3) / steps;
      const Eigen::Vector3d point = a + u * (b - a) + v * (c - a);
      int textured = 0;
      for (const int view : facing) {
        if (!IsTextured(view, point) || !rays_.Sees(views_[view].camera, point, normal)) continue;
        if (++textured == 2) return true;
      }
    }
  }
  return false;
}

}  // namespace burin
