#include "selection/sparse_point_pairs.h"

#include <Eigen/Core>
#include <cmath>

#include "selection/ranking.h"

namespace burin {

std::vector<int> CommonPointCounts(const Scene& scene, double min_deg, double max_deg) {
  const size_t n = scene.views.size();
  std::vector<int> counts(n * n, 0);
  const double max_cos = std::cos(min_deg * M_PI / 180);
  const double min_cos = std::cos(max_deg * M_PI / 180);
  std::vector<Eigen::Vector3d> directions;
  std::vector<Eigen::Vector3d> centers(n);
  for (size_t i = 0; i < n; ++i) centers[i] = scene.views[i].camera.Center();
  for (const ScenePoint& point : scene.points) {
    directions.clear();
    for (int view : point.views) {
      directions.push_back((centers[view] - point.position).normalized());
    }
    for (size_t a = 0; a < directions.size(); ++a) {
      for (size_t b = a + 1; b < directions.size(); ++b) {
        const double cosine = directions[a].dot(directions[b]);
        if (cosine > max_cos || cosine < min_cos) continue;
        const size_t i = point.views[a];
        const size_t j = point.views[b];
        ++counts[i * n + j];
        ++counts[j * n + i];
      }
    }
  }
  return counts;
}

std::vector<CameraPair> SparsePointPairs(const Scene& scene, int per_camera, double min_deg,
                                         double max_deg) {
  return BestPartners(CommonPointCounts(scene, min_deg, max_deg),
                      static_cast<int>(scene.views.size()), per_camera);
}

}  // namespace burin
