#include "selection/sparse_point_pairs.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

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
  const int n = static_cast<int>(scene.views.size());
  const std::vector<int> counts = CommonPointCounts(scene, min_deg, max_deg);
  std::vector<CameraPair> pairs;
  std::vector<int> order(n);
  for (int i = 0; i < n; ++i) {
    const int* row = counts.data() + static_cast<size_t>(i) * n;
    for (int j = 0; j < n; ++j) order[j] = j;
    std::stable_sort(order.begin(), order.end(), [row](int a, int b) { return row[a] > row[b]; });
    for (int k = 0; k < per_camera && k < n && row[order[k]] > 0; ++k) {
      pairs.push_back({i, order[k]});
    }
  }
  return pairs;
}

}  // namespace burin
