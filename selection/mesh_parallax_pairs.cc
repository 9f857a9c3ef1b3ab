#include "selection/mesh_parallax_pairs.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/visibility.h"
#include "selection/ranking.h"

namespace burin {
namespace {

constexpr double kSmallestShare = 1e-4;  // of the image: less overlap than this is none

}  // namespace

std::vector<double> SharedFacetAreas(const Scene& scene, const TriangleMesh& mesh, double min_deg,
                                     double max_deg) {
  const int n = static_cast<int>(scene.views.size());
  const size_t faces = mesh.faces.size();
  std::vector<Eigen::Vector3d> centroids(faces);
  for (size_t f = 0; f < faces; ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    centroids[f] = (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
  }
  const RayCaster caster(mesh);
  // Projected area of each facet in each view where it is visible, else 0.
  std::vector<std::vector<double>> area(n, std::vector<double>(faces, 0.0));
  for (int i = 0; i < n; ++i) {
    const Camera& camera = scene.views[i].camera;
    std::vector<Eigen::Vector3d> points;
    std::vector<int> facets;
    for (size_t f = 0; f < faces; ++f) {
      if (camera.Depth(centroids[f]) <= 0 || !camera.Contains(camera.Project(centroids[f]))) {
        continue;
      }
      points.push_back(centroids[f]);
      facets.push_back(static_cast<int>(f));
    }
    std::vector<uint8_t> visible;
    caster.PointsVisible(camera.Center(), points, facets, &visible);
    for (size_t k = 0; k < points.size(); ++k) {
      if (visible[k] == 0) continue;
      const Eigen::Vector3d to_camera = camera.Center() - points[k];
      const double cosine = FaceAreaNormal(mesh, facets[k]).dot(to_camera.normalized());
      const double footprint = camera.Footprint(points[k]);
      area[i][facets[k]] = 0.5 * std::max(0.0, cosine) / (footprint * footprint);
    }
  }
  const double max_cos = std::cos(min_deg * M_PI / 180);
  const double min_cos = std::cos(max_deg * M_PI / 180);
  std::vector<double> scores(static_cast<size_t>(n) * n, 0.0);
  ParallelFor(n, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector3d center_i = scene.views[i].camera.Center();
      const double image =
          static_cast<double>(scene.views[i].camera.width) * scene.views[i].camera.height;
      for (int j = 0; j < n; ++j) {
        if (i == j) continue;
        const Eigen::Vector3d center_j = scene.views[j].camera.Center();
        double sum = 0;
        for (size_t f = 0; f < faces; ++f) {
          if (area[i][f] == 0 || area[j][f] == 0) continue;
          const double cosine =
              (center_i - centroids[f]).normalized().dot((center_j - centroids[f]).normalized());
          if (cosine <= max_cos && cosine >= min_cos) sum += area[i][f];
        }
        scores[static_cast<size_t>(i) * n + j] = sum >= kSmallestShare * image ? sum : 0;
      }
    }
  });
  return scores;
}

std::vector<CameraPair> MeshParallaxPairs(const Scene& scene, const TriangleMesh& mesh,
                                          int per_camera, double min_deg, double max_deg) {
  return BestPartners(SharedFacetAreas(scene, mesh, min_deg, max_deg),
                      static_cast<int>(scene.views.size()), per_camera);
}

}  // namespace burin
