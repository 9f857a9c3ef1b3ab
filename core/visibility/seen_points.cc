#include "core/visibility/seen_points.h"

#include <algorithm>
#include <cmath>

#include "core/support/parallel.h"
#include "core/visibility/mesh_rays.h"

namespace burin {
namespace {

std::vector<Eigen::Vector3d> PointsOf(const MeshRays& rays, const View& view, int count) {
  const Camera& camera = view.camera;
  std::vector<Eigen::Vector3d> points;
  if (camera.width <= 0 || camera.height <= 0 || count <= 0) return points;
  // The largest grid of squares that fits: rounded down on both sides, it has at most `count` places.
  const double area = static_cast<double>(camera.width) * camera.height;
  const double spacing = std::max(1.0, std::sqrt(area / count));
  const int cols = std::clamp(static_cast<int>(camera.width / spacing), 1, count);
  const int rows = std::clamp(static_cast<int>(camera.height / spacing), 1, count / cols);
  const Eigen::Vector3d center = camera.Center();
  for (int r = 0; r < rows; ++r) {
    const int y = static_cast<int>((r + 0.5) * camera.height / rows);
    for (int c = 0; c < cols; ++c) {
      const int x = static_cast<int>((c + 0.5) * camera.width / cols);
      if (!view.mask.empty() && view.mask.at<unsigned char>(y, x) == 0) continue;
      const Eigen::Vector3d ray = camera.Ray(x + 0.5, y + 0.5);
      RayHit hit;
      if (!rays.Intersect(center + camera.near_depth * ray, ray, &hit)) continue;
      if (FaceAreaNormal(rays.mesh(), hit.face).dot(ray) >= 0) continue;
      points.push_back(hit.point);
    }
  }
  return points;
}

}  // namespace

std::vector<std::vector<Eigen::Vector3d>> SeenPoints(const TriangleMesh& mesh,
                                                     const std::vector<View>& views, int count) {
  std::vector<std::vector<Eigen::Vector3d>> points(views.size());
  if (mesh.faces.empty()) return points;
  const MeshRays rays(mesh);
  ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) points[v] = PointsOf(rays, views[v], count);
  });
  return points;
}

}  // namespace burin
