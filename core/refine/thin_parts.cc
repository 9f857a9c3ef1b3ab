#include "core/refine/thin_parts.h"

#include "core/support/parallel.h"
#include "core/visibility/mesh_rays.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 512;
// Of `width`: the ray begins inside, clear of the facets at the vertex.
constexpr double kClear = 1e-2;

}  // namespace

std::vector<char> ThinVertices(const TriangleMesh& mesh,
                               const std::vector<Eigen::Vector3d>& normals, double width) {
  return ThinVertices(mesh, normals, std::vector<double>(mesh.vertices.size(), width));
}

std::vector<char> ThinVertices(const TriangleMesh& mesh,
                               const std::vector<Eigen::Vector3d>& normals,
                               const std::vector<double>& width) {
  const MeshRays rays(mesh);
  const auto count = static_cast<int>(mesh.vertices.size());
  std::vector<char> thin(count, 0);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      if (normals[v].isZero()) continue;
      const Eigen::Vector3d inward = -normals[v];
      RayHit hit;
      if (!rays.Intersect(mesh.vertices[v] + kClear * width[v] * inward, inward, &hit, width[v])) {
        continue;
      }
      if (FaceAreaNormal(mesh, hit.face).dot(inward) > 0) thin[v] = 1;
    }
  });
  return thin;
}

}  // namespace burin
