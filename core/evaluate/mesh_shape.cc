#include "core/evaluate/mesh_shape.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/facet_quality.h"

namespace burin {
namespace {

// Least and largest cosine of the angles; -1 and 1 where there is no area.
std::pair<double, double> Cosines(const TriangleMesh& mesh, const Eigen::Vector3i& face) {
  double least = 1;
  double largest = -1;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d& corner = mesh.vertices[face[k]];
    const Eigen::Vector3d u = mesh.vertices[face[(k + 1) % 3]] - corner;
    const Eigen::Vector3d v = mesh.vertices[face[(k + 2) % 3]] - corner;
    if (u.cross(v).isZero(0)) return {-1, 1};
    const double cosine = u.normalized().dot(v.normalized());
    least = std::min(least, cosine);
    largest = std::max(largest, cosine);
  }
  return {least, largest};
}

}  // namespace

MeshShape ShapeOf(const TriangleMesh& mesh) {
  MeshShape shape;
  if (mesh.faces.empty()) return shape;
  const double degree = std::acos(-1.0) / 180;
  const double share = 1.0 / static_cast<double>(mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    const auto [least, largest] = Cosines(mesh, face);
    shape.quality += share * FacetQuality(mesh.vertices[face[0]], mesh.vertices[face[1]],
                                          mesh.vertices[face[2]]);
    if (largest > std::cos(10 * degree)) shape.under_10_deg += share;
    if (least < std::cos(150 * degree)) shape.over_150_deg += share;
  }
  return shape;
}

}  // namespace burin
