#include "core/refine/normalized_world.h"

#include <utility>
#include <vector>

#include "core/support/median.h"

namespace burin {

NormalizedWorld NormalizedWorld::Of(const Scene& scene, const TriangleMesh& mesh) {
  return {BoundingBox(mesh).center(), MedianFootprint(scene, mesh)};
}

TriangleMesh NormalizedWorld::FromWorld(TriangleMesh mesh) const {
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = (vertex - origin) / footprint;
  return mesh;
}

TriangleMesh NormalizedWorld::ToWorld(TriangleMesh mesh) const {
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = vertex * footprint + origin;
  return mesh;
}

Camera NormalizedWorld::FromWorld(const Camera& camera, int width, int height) const {
  return camera.Resized(width, height).InScaledWorld(origin, 1 / footprint);
}

double MedianFootprint(const Scene& scene, const TriangleMesh& mesh) {
  std::vector<double> footprints;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    double smallest = 0;
    for (const View& view : scene.views) {
      if (view.camera.Depth(vertex) <= 0 || !view.camera.Contains(view.camera.Project(vertex))) {
        continue;
      }
      const double footprint = view.camera.Footprint(vertex);
      if (smallest == 0 || footprint < smallest) smallest = footprint;
    }
    if (smallest > 0) footprints.push_back(smallest);
  }
  return footprints.empty() ? 0 : Median(std::move(footprints));
}

}  // namespace burin
