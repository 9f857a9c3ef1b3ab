#include "core/mesh/smooth_rims.h"

#include <algorithm>
#include <array>

#include "core/mesh/facet_quality.h"

namespace burin {
namespace {

constexpr int kSteps = 10;
constexpr double kForward = 0.5;
constexpr double kBack = -0.53;
constexpr double kGoodQuality = 0.5;
constexpr double kLeastCosine = 0.5;

double Quality(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3i& face = mesh.faces[f];
  return FacetQuality(mesh.vertices[face[0]], mesh.vertices[face[1]], mesh.vertices[face[2]]);
}

struct RimVertex {
  int vertex;
  std::array<int, 2> neighbors;  // on the border
  Eigen::Vector3d normal;
};

// Free vertices with two edges that have one facet each.
std::vector<RimVertex> RimVertices(const TriangleMesh& mesh, const Adjacency& faces,
                                   const std::vector<char>& free) {
  const Adjacency neighbors = VertexNeighbors(mesh, faces);
  const std::vector<char> boundary = BoundaryVertices(mesh, faces);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(mesh, faces);
  std::vector<RimVertex> rim;
  for (size_t k = 0; k < mesh.vertices.size(); ++k) {
    const auto v = static_cast<int>(k);
    if (free[v] == 0 || boundary[v] == 0) continue;
    std::vector<int> along;
    for (const int* n = neighbors.Begin(v); n != neighbors.End(v); ++n) {
      const auto shared = std::count_if(faces.Begin(v), faces.End(v),
                                        [&](int f) { return (mesh.faces[f].array() == *n).any(); });
      if (shared == 1) along.push_back(*n);
    }
    if (along.size() == 2) rim.push_back({v, {along[0], along[1]}, normals[v]});
  }
  return rim;
}

// The vertex goes by `by`, unless that spoils a facet.
void Move(const Adjacency& faces, const std::vector<double>& quality,
          const std::vector<Eigen::Vector3d>& facet_normals, int v, const Eigen::Vector3d& by,
          TriangleMesh* mesh) {
  const Eigen::Vector3d before = mesh->vertices[v];
  mesh->vertices[v] += by;
  const bool good = std::all_of(faces.Begin(v), faces.End(v), [&](int f) {
    const Eigen::Vector3d normal = FaceAreaNormal(*mesh, f);
    return Quality(*mesh, f) >= std::min(kGoodQuality, quality[f]) &&
           normal.dot(facet_normals[f]) >= kLeastCosine * normal.norm();
  });
  if (!good) mesh->vertices[v] = before;
}

}  // namespace

void SmoothRims(const std::vector<char>& free, TriangleMesh* mesh) {
  const Adjacency faces = VertexFaces(*mesh);
  const std::vector<RimVertex> rim = RimVertices(*mesh, faces, free);
  std::vector<double> quality(mesh->faces.size());
  std::vector<Eigen::Vector3d> facet_normals(mesh->faces.size());
  for (size_t f = 0; f < mesh->faces.size(); ++f) {
    quality[f] = Quality(*mesh, static_cast<int>(f));
    facet_normals[f] = FaceAreaNormal(*mesh, static_cast<int>(f)).normalized();
  }
  for (int step = 0; step < 2 * kSteps; ++step) {
    const double share = step % 2 == 0 ? kForward : kBack;
    for (const RimVertex& at : rim) {
      const Eigen::Vector3d middle =
          0.5 * (mesh->vertices[at.neighbors[0]] + mesh->vertices[at.neighbors[1]]);
      Eigen::Vector3d by = middle - mesh->vertices[at.vertex];
      by -= at.normal * at.normal.dot(by);
      Move(faces, quality, facet_normals, at.vertex, share * by, mesh);
    }
  }
}

}  // namespace burin
