#include "core/refine/carry.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

namespace burin {
namespace {

// Of the residual; displacements are pixels.
constexpr double kTolerance = 1e-6;

// Vertices that a path of unplaced ones connects to a placed one, by their order of discovery.
std::vector<int> Reached(const Adjacency& neighbors, const std::vector<char>& placed) {
  const auto count = static_cast<int>(placed.size());
  std::vector<char> known(placed.begin(), placed.end());
  std::vector<int> list;
  const auto visit_neighbors = [&](int v) {
    for (const int* w = neighbors.Begin(v); w != neighbors.End(v); ++w) {
      if (known[*w] != 0) continue;
      known[*w] = 1;
      list.push_back(*w);
    }
  };
  for (int v = 0; v < count; ++v) {
    if (placed[v] != 0) visit_neighbors(v);
  }
  for (size_t k = 0; k < list.size(); ++k) visit_neighbors(list[k]);
  return list;
}

}  // namespace

int CarryAlong(const Adjacency& neighbors, const std::vector<char>& placed,
               const std::vector<Eigen::Vector3d>& before, TriangleMesh* mesh) {
  const std::vector<int> list = Reached(neighbors, placed);
  const auto count = static_cast<int>(list.size());
  if (count == 0) return 0;
  std::vector<int> index(before.size(), -1);
  for (int k = 0; k < count; ++k) index[list[k]] = k;
  // Graph Laplacian: degree(v) d_v - sum over neighbours d_w = 0, symmetric and positive definite.
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(count, 3);
  for (int k = 0; k < count; ++k) {
    const int v = list[k];
    entries.emplace_back(k, k, neighbors.Degree(v));
    for (const int* w = neighbors.Begin(v); w != neighbors.End(v); ++w) {
      if (index[*w] >= 0) {
        entries.emplace_back(k, index[*w], -1.0);
      } else {
        right.row(k) += (mesh->vertices[*w] - before[*w]).transpose();
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(kTolerance);
  solver.compute(matrix);
  const Eigen::MatrixX3d displacement = solver.solve(right);
  for (int k = 0; k < count; ++k) {
    mesh->vertices[list[k]] = before[list[k]] + displacement.row(k).transpose();
  }
  return count;
}

}  // namespace burin
