#include "core/mesh/smoothed_normals.h"

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 2048;
constexpr double kLeastMean = 0.3;

}  // namespace

std::vector<Eigen::Vector3d> SmoothedNormals(const TriangleMesh& mesh, const Adjacency& faces,
                                             const Adjacency& neighbors, int rounds) {
  std::vector<Eigen::Vector3d> normals = VertexNormals(mesh, faces);
  std::vector<Eigen::Vector3d> smoothed(normals.size());
  for (int round = 0; round < rounds; ++round) {
    ParallelFor(static_cast<int>(normals.size()), kVertexGrain, [&](int begin, int end) {
      for (int v = begin; v < end; ++v) {
        Eigen::Vector3d sum = normals[v];
        for (const int* w = neighbors.Begin(v); w != neighbors.End(v); ++w) sum += normals[*w];
        const double length = sum.norm();
        const bool agree = length > kLeastMean * (1 + neighbors.Degree(v));
        smoothed[v] = agree ? Eigen::Vector3d(sum / length) : normals[v];
      }
    });
    normals.swap(smoothed);
  }
  return normals;
}

}  // namespace burin
