#include "core/mesh/surface_walk.h"

#include <algorithm>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 2048;
// A squared distance, in squares of the facet's size.
constexpr double kFarOff = 0.06;

bool HasVertex(const Eigen::Vector3i& face, int v) {
  return face[0] == v || face[1] == v || face[2] == v;
}

}  // namespace

SurfaceWalk::SurfaceWalk(const TriangleMesh& mesh)
    : mesh_(mesh), vertex_faces_(VertexFaces(mesh)), across_(mesh.faces.size()) {
  ParallelFor(static_cast<int>(mesh.faces.size()), kFacetGrain, [&](int begin, int end) {
    for (int f = begin; f < end; ++f) {
      for (int c = 0; c < 3; ++c) {
        const int from = mesh.faces[f][c];
        const int to = mesh.faces[f][(c + 1) % 3];
        const int* const last = vertex_faces_.End(from);
        const int* const other = std::find_if(vertex_faces_.Begin(from), last, [&](int g) {
          return g != f && HasVertex(mesh.faces[g], to);
        });
        across_[f][c] = other != last ? *other : -1;
      }
    }
  });
}

TrianglePoint SurfaceWalk::Closest(const Eigen::Vector3d& query, int facet) const {
  const Eigen::Vector3i& face = mesh_.faces[facet];
  const Eigen::Vector3d corners[3] = {mesh_.vertices[face[0]], mesh_.vertices[face[1]],
                                      mesh_.vertices[face[2]]};
  return ClosestOnTriangle(query, corners);
}

TrianglePoint SurfaceWalk::Find(const Eigen::Vector3d& query, double far, int* facet) const {
  TrianglePoint best = Closest(query, *facet);
  for (;;) {
    const Eigen::Vector3i face = mesh_.faces[*facet];
    int next = -1;
    const auto look_at = [&](int f) {
      const TrianglePoint point = Closest(query, f);
      if (!(point.squared_distance < best.squared_distance)) return;
      best = point;
      next = f;
    };
    const auto look_around = [&](int corner) {
      std::for_each(vertex_faces_.Begin(corner), vertex_faces_.End(corner), look_at);
    };
    if (best.feature == TriangleFeature::kEdge) {
      const int other = across_[*facet][best.which];
      if (other >= 0) look_at(other);
    } else if (best.feature == TriangleFeature::kCorner) {
      look_around(face[best.which]);
    }
    if (next < 0 && best.squared_distance >
                        std::min(far * far, kFarOff * FaceAreaNormal(mesh_, *facet).norm())) {
      for (const int corner : face) look_around(corner);
    }
    if (next < 0) return best;
    *facet = next;
  }
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
