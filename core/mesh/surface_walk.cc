#include "core/mesh/surface_walk.h"

namespace burin {

SurfaceWalk::SurfaceWalk(const TriangleMesh& mesh)
    : mesh_(mesh), vertex_faces_(VertexFaces(mesh)) {}

TrianglePoint SurfaceWalk::Closest(const Eigen::Vector3d& query, int facet) const {
  const Eigen::Vector3i& face = mesh_.faces[facet];
  const Eigen::Vector3d corners[3] = {mesh_.vertices[face[0]], mesh_.vertices[face[1]],
                                      mesh_.vertices[face[2]]};
  return ClosestOnTriangle(query, corners);
}

TrianglePoint SurfaceWalk::Find(const Eigen::Vector3d& query, int* facet) const {
  TrianglePoint best = Closest(query, *facet);
  while (best.feature != TriangleFeature::kFace) {
    // The others at the corner, or across the edge.
    const Eigen::Vector3i& face = mesh_.faces[*facet];
    const int at = face[best.which];
    const int end = best.feature == TriangleFeature::kEdge ? face[(best.which + 1) % 3] : at;
    int next = -1;
    for (const int* f = vertex_faces_.Begin(at); f != vertex_faces_.End(at); ++f) {
      if (*f == *facet || !(mesh_.faces[*f].array() == end).any()) continue;
      const TrianglePoint point = Closest(query, *f);
      if (!(point.squared_distance < best.squared_distance)) continue;
      best = point;
      next = *f;
    }
    if (next < 0) break;
    *facet = next;
  }
  return best;
}

Eigen::Vector3d SurfaceWalk::Weights(int facet, const TrianglePoint& at) const {
  const Eigen::Vector3i& face = mesh_.faces[facet];
  if (at.feature == TriangleFeature::kCorner) return Eigen::Vector3d::Unit(at.which);
  const int next = (at.which + 1) % 3;
  const int last = (at.which + 2) % 3;
  const Eigen::Vector3d& origin = mesh_.vertices[face[at.which]];
  const Eigen::Vector3d to_next = mesh_.vertices[face[next]] - origin;
  const Eigen::Vector3d offset = at.point - origin;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  if (at.feature == TriangleFeature::kEdge) {
    weights[next] = offset.dot(to_next) / to_next.squaredNorm();
  } else {
    const Eigen::Vector3d to_last = mesh_.vertices[face[last]] - origin;
    const Eigen::Vector3d normal = to_next.cross(to_last);
    weights[next] = normal.dot(offset.cross(to_last)) / normal.squaredNorm();
    weights[last] = normal.dot(to_next.cross(offset)) / normal.squaredNorm();
  }
  if (!weights.allFinite()) return Eigen::Vector3d::Unit(at.which);  // hardly any area
  weights = weights.cwiseMax(0.0).cwiseMin(1.0);
  weights[at.which] = std::max(0.0, 1 - weights.sum());
  return weights / weights.sum();
}

}  // namespace burin
