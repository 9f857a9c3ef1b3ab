#include "costs/patch_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace burin {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// delta relative to the mean diagonal of H, plus a floor for patches without texture. Ten times that where it does not
// outweigh the rounding of sums in single precision, by which H may have small negative eigenvalues.
constexpr double kRelativeDamping = 1e-6;
constexpr int kTries = 4;
constexpr double kAbsoluteDamping = 1e-9;

// H + delta I factored, and what follows from it. Of one thread, to be used again.
struct Factored {
  std::vector<double> matrix;  // L, row-major, in the lower triangle
  std::vector<double> solved;  // L^-1 g
  double damping = 0;          // delta
  double beta = 1;             // 0 where the patch's windows agree and its gradient is rounding

  // False where the system is not finite.
  bool Make(const PatchSystem& system);
};

bool Factored::Make(const PatchSystem& system) {
  const int n = system.Unknowns();
  solved = system.gradient;
  const Eigen::Map<const Matrix> curvature(system.curvature.data(), n, n);
  damping = kRelativeDamping * curvature.trace() / n + kAbsoluteDamping;
  matrix.resize(system.curvature.size());
  Eigen::Map<Matrix> map(matrix.data(), n, n);
  bool factored = false;
  for (int tries = 0; tries < kTries && !factored; ++tries) {
    if (tries > 0) damping *= 10;
    map = curvature;
    map.diagonal().array() += damping;
    const Eigen::LLT<Eigen::Ref<Matrix>> factor(map);  // in place
    factored = factor.info() == Eigen::Success;
  }
  if (!factored) return false;
  Eigen::Map<Eigen::VectorXd> r(solved.data(), n);
  map.triangularView<Eigen::Lower>().solveInPlace(r);
  const double squared = r.squaredNorm();
  if (!std::isfinite(squared + system.cost)) return false;
  beta = 1;
  if (squared > 2 * system.cost) {
    beta = system.cost <= 0 ? 0 : std::sqrt(squared / (2 * system.cost));
  }
  return true;
}

}  // namespace

void PatchVertices(const RoundContext& context, int vertex, std::vector<int>* vertices) {
  vertices->assign(1, vertex);
  for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
    for (const int v : context.mesh->faces[*f]) {
      if (std::find(vertices->begin(), vertices->end(), v) == vertices->end()) {
        vertices->push_back(v);
      }
    }
  }
}

void PatchSystem::Make(const PhotometricRound& round, int vertex) {
  const RoundContext& context = round.context();
  PatchVertices(context, vertex, &vertices);
  first_unknown.assign(1, 0);
  for (const int v : vertices) first_unknown.push_back(first_unknown.back() + context.Unknowns(v));
  const size_t n = first_unknown.back();
  cost = 0;
  gradient.assign(n, 0.0);
  curvature.assign(n * n, 0.0);
  for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
    const Eigen::Vector3i& face = context.mesh->faces[*f];
    const int own = face[0] == vertex ? 0 : (face[1] == vertex ? 1 : 2);
    const CornerSums sums = round.corner_sums()[3 * static_cast<size_t>(*f) + own];
    const Eigen::Vector3d& normal = round.facet_normals()[*f];
    cost += sums.share;
    size_t first[3];
    int count[3];
    Eigen::Vector3d along[3];  // n . d of every unknown
    for (int k = 0; k < 3; ++k) {
      const auto local = std::find(vertices.begin(), vertices.end(), face[k]) - vertices.begin();
      first[k] = first_unknown[local];
      count[k] = context.Unknowns(face[k]);
      along[k] = normal;
      if (context.MovesAlongNormal(face[k])) along[k][0] = normal.dot(context.normals[face[k]]);
    }
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < count[k]; ++c) {
        const size_t row = first[k] + c;
        gradient[row] += sums.slope[k] * along[k][c];
        for (int l = 0; l < 3; ++l) {
          const double value = sums.curvature[CornerSums::Packed(k, l)];
          for (int d = 0; d < count[l]; ++d) {
            curvature[row * n + first[l] + d] += value * along[k][c] * along[l][d];
          }
        }
      }
    }
  }
}

PatchScale ScaleOf(const PatchSystem& system) {
  static thread_local Factored factored;
  if (!factored.Make(system)) {
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  }
  const double squared = factored.beta > 0 ? factored.beta * factored.beta : 1;
  return {squared, squared * factored.damping};
}

void Factor(const PatchSystem& system, PatchFactor* result) {
  static thread_local Factored factored;
  result->valid = factored.Make(system);
  if (!result->valid) return;
  const auto n = static_cast<size_t>(system.Unknowns());
  result->values.clear();
  result->values.reserve(n + 1 + n * (n + 1) / 2);
  double squared = 0;
  for (const double solved : factored.solved) {
    const double r = factored.beta > 0 ? solved / factored.beta : 0;
    squared += r * r;
    result->values.push_back(r);
  }
  result->values.push_back(std::sqrt(std::max(0.0, 2 * system.cost - squared)));
  const double scale = factored.beta > 0 ? factored.beta : 1;
  for (size_t row = 0; row < n; ++row) {
    for (size_t column = 0; column <= row; ++column) {
      result->values.push_back(scale * factored.matrix[row * n + column]);
    }
  }
}

}  // namespace burin
