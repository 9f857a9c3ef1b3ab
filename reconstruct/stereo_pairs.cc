#include "reconstruct/stereo_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/median.h"

namespace burin {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr size_t kLeastPoints = 20;
constexpr double kAngleSpread = 0.5;  // of the logarithm

}  // namespace

std::vector<std::vector<int>> ChooseStereoPartners(const Scene& scene, const StereoRules& rules) {
  const size_t count = scene.views.size();
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : scene.views) centers.push_back(view.camera.Center());
  std::vector<std::vector<double>> angles(count * count);  // of each i < j
  for (const ScenePoint& point : scene.points) {
    for (size_t a = 0; a < point.views.size(); ++a) {
      const Eigen::Vector3d to_a = centers[point.views[a]] - point.position;
      for (size_t b = a + 1; b < point.views.size(); ++b) {
        const Eigen::Vector3d to_b = centers[point.views[b]] - point.position;
        angles[point.views[a] * count + point.views[b]].push_back(
            kDegrees * std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b)));
      }
    }
  }
  std::vector<std::vector<std::pair<double, int>>> scores(count);
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = i + 1; j < count; ++j) {
      std::vector<double>& of = angles[i * count + j];
      if (of.size() < kLeastPoints) continue;
      const auto shared = static_cast<double>(of.size());
      const double angle = Median(std::move(of));
      if (angle < rules.min_angle_deg || angle > rules.max_angle_deg) continue;
      const double off = std::log(angle / rules.best_angle_deg) / kAngleSpread;
      const double score = shared * std::exp(-off * off / 2);
      scores[i].emplace_back(-score, static_cast<int>(j));
      scores[j].emplace_back(-score, static_cast<int>(i));
    }
  }
  std::vector<std::vector<int>> partners(count);
  for (size_t i = 0; i < count; ++i) {
    std::sort(scores[i].begin(), scores[i].end());
    for (const auto& [score, j] : scores[i]) {
      if (static_cast<int>(partners[i].size()) < rules.partners) partners[i].push_back(j);
    }
  }
  return partners;
}

}  // namespace burin
