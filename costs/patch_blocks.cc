#include "costs/patch_blocks.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/support/parallel.h"
#include "costs/patch_cost.h"

namespace burin {
namespace {

constexpr int kPatchGrain = 256;

// delta relative to the mean diagonal of H, plus a floor for patches without texture.
constexpr double kRelativeDamping = 1e-6;
constexpr double kAbsoluteDamping = 1e-9;

// Index into CornerSums::curvature.
constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

// delta, of n unknowns.
double Damping(double trace, int n) { return kRelativeDamping * trace / n + kAbsoluteDamping; }

// beta of a patch with |L^-1 g|^2 = `squared`; 0 where its windows agree and its gradient is rounding.
double Beta(double squared, double cost) {
  if (squared <= 2 * cost) return 1;
  return cost <= 0 ? 0 : std::sqrt(squared / (2 * cost));
}

// The corner of a facet that is the patch's vertex.
int OwnCorner(const uint16_t* block) { return block[0] == 0 ? 0 : (block[1] == 0 ? 1 : 2); }

// Vertices of the facets of `vertex`, itself first.
Adjacency Rings(const RoundContext& context, const std::vector<int>& vertices) {
  const auto count = static_cast<int>(vertices.size());
  Adjacency rings;
  rings.start.assign(count + 1, 0);
  for (int k = 0; k < count; ++k) {
    const int vertex = vertices[k];
    const auto begin = static_cast<ptrdiff_t>(rings.index.size());
    rings.index.push_back(vertex);
    for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
      for (const int v : context.mesh->faces[*f]) {
        if (std::find(rings.index.begin() + begin, rings.index.end(), v) == rings.index.end()) {
          rings.index.push_back(v);
        }
      }
    }
    rings.start[k + 1] = static_cast<int>(rings.index.size());
  }
  rings.index.shrink_to_fit();
  return rings;
}

}  // namespace

PatchBlocks::PatchBlocks(const PhotometricRound* round, const std::vector<int>& vertices)
    : EnergyBlocks(Rings(round->context(), vertices)), round_(round) {
  const RoundContext& context = round->context();
  first_corners_.reserve(size() + 1);
  first_corners_.push_back(0);
  for (const int vertex : vertices) {
    first_corners_.push_back(first_corners_.back() + context.faces.Degree(vertex));
  }
  corners_.resize(first_corners_.back());
  ParallelFor(size(), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      CHECK_LE(parameters_.Degree(k), std::numeric_limits<uint16_t>::max());
      const int vertex = VertexOf(k);
      Corners* corners = &corners_[first_corners_[k]];
      for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
        for (int c = 0; c < 3; ++c) {
          const int* found =
              std::find(parameters_.Begin(k), parameters_.End(k), context.mesh->faces[*f][c]);
          corners->block[c] = static_cast<uint16_t>(found - parameters_.Begin(k));
        }
        ++corners;
      }
    }
  });
}

int PatchBlocks::Unknowns(int patch) const {
  return (round_->context().motion == Motion::kNormal ? 1 : 3) * parameters_.Degree(patch);
}

PatchSystem PatchBlocks::System(int patch) const {
  const int n = Unknowns(patch);
  PatchSystem system;
  system.gradient.setZero(n);
  system.curvature.setZero(n, n);
  Assemble(patch, &system.cost, system.gradient.data(), system.curvature.data());
  return system;
}

void PatchBlocks::Assemble(int patch, double* cost, double* gradient, double* curvature) const {
  const RoundContext& context = round_->context();
  const bool normal_motion = context.motion == Motion::kNormal;
  const ptrdiff_t n = Unknowns(patch);
  const int vertex = VertexOf(patch);
  const int* blocks = parameters_.Begin(patch);
  const Corners* corners = &corners_[first_corners_[patch]];
  *cost = 0;
  for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
    const uint16_t* local = (corners++)->block;
    const CornerSums& sums = round_->corner_sums()[3 * static_cast<size_t>(*f) + OwnCorner(local)];
    const Eigen::Vector3d& normal = round_->facet_normals()[*f];
    *cost += sums.share;
    double along[3] = {0, 0, 0};  // n . N_k
    for (int k = 0; k < 3 && normal_motion; ++k) {
      along[k] = normal.dot(context.normals[blocks[local[k]]]);
    }
    for (int k = 0; k < 3; ++k) {
      const ptrdiff_t row = local[k];
      if (normal_motion) {
        gradient[row] += sums.slope[k] * along[k];
      } else {
        for (int c = 0; c < 3; ++c) gradient[3 * row + c] += sums.slope[k] * normal[c];
      }
      for (int l = 0; l < 3; ++l) {
        const ptrdiff_t column = local[l];
        const double value = sums.curvature[kPacked[k][l]];
        if (normal_motion) {
          curvature[row * n + column] += value * along[k] * along[l];
          continue;
        }
        for (int c = 0; c < 3; ++c) {
          for (int d = 0; d < 3; ++d) {
            curvature[(3 * row + c) * n + 3 * column + d] += value * normal[c] * normal[d];
          }
        }
      }
    }
  }
}

void PatchBlocks::Factor(int patch, PatchFactor* result) const {
  result->at = round_->EvaluationCount();
  PatchSystem system = System(patch);
  const auto n = static_cast<int>(system.gradient.size());
  system.curvature.diagonal().array() += Damping(system.curvature.trace(), n);
  const Eigen::LLT<Eigen::MatrixXd> factor(system.curvature);
  result->valid = factor.info() == Eigen::Success;
  if (!result->valid) return;
  Eigen::VectorXd r = factor.matrixL().solve(system.gradient);
  const double squared = r.squaredNorm();
  result->valid = std::isfinite(squared + system.cost);  // as where a facet is turned edge-on
  if (!result->valid) return;
  const double beta = Beta(squared, system.cost);
  if (beta > 0) {
    r /= beta;
  } else {
    r.setZero();
  }
  const auto rows = static_cast<size_t>(n) + 1;
  result->values.resize(rows + static_cast<size_t>(n) * (n + 1) / 2);
  std::copy(r.data(), r.data() + n, result->values.begin());
  result->values[n] = std::sqrt(std::max(0.0, 2 * system.cost - r.squaredNorm()));
  const double scale = beta > 0 ? beta : 1;
  double* entry = result->values.data() + rows;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column <= row; ++column) {
      *entry++ = scale * factor.matrixLLT()(row, column);
    }
  }
}

// The cost, and whether Evaluate() would find it finite, without derivatives.
bool PatchBlocks::EvaluateCost(int patch, double* cost) const {
  const RoundContext& context = round_->context();
  const int vertex = VertexOf(patch);
  const Corners* corners = &corners_[first_corners_[patch]];
  double sum = 0;
  double finite = 0;
  for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
    const uint16_t* local = (corners++)->block;
    const CornerSums& sums = round_->corner_sums()[3 * static_cast<size_t>(*f) + OwnCorner(local)];
    const double normal = round_->facet_normals()[*f].squaredNorm();
    sum += sums.share;
    finite += normal * (sums.curvature[0] + sums.curvature[3] + sums.curvature[5]) +
              normal * (sums.slope[0] + sums.slope[1] + sums.slope[2]);
  }
  *cost = std::max(0.0, sum);
  return std::isfinite(sum + finite);
}

bool PatchBlocks::Evaluate(int patch, const TangentDirections* directions, double* energy,
                           double* gradient, double* curvature) const {
  if (gradient == nullptr) return EvaluateCost(patch, energy);
  static thread_local std::vector<double> scratch;
  const ptrdiff_t n = Unknowns(patch);
  scratch.assign(static_cast<size_t>(2 * n * (n + 1)), 0.0);
  double* const own_gradient = scratch.data();
  double* const own_curvature = own_gradient + n;
  double* const solved = own_curvature + n * n;
  double* const factored = solved + n;
  double sum = 0;
  Assemble(patch, &sum, own_gradient, own_curvature);
  Eigen::Map<Eigen::MatrixXd> matrix(own_curvature, n, n);
  matrix.diagonal().array() += Damping(matrix.trace(), static_cast<int>(n));
  Eigen::Map<Eigen::MatrixXd> copy(factored, n, n);
  copy = matrix;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(copy);  // in place
  if (factor.info() != Eigen::Success) return false;
  Eigen::Map<Eigen::VectorXd> r(solved, n);
  r = Eigen::Map<const Eigen::VectorXd>(own_gradient, n);
  factor.matrixL().solveInPlace(r);
  const double squared = r.squaredNorm();
  if (!std::isfinite(squared + sum)) return false;
  const double beta = Beta(squared, sum);
  *energy = std::max(0.0, sum);

  // From the patch's own unknowns to those of the solve: of each, its block and how it moves that.
  const bool normal_motion = round_->context().motion == Motion::kNormal;
  const int own = normal_motion ? 1 : 3;  // unknowns of a block
  struct Unknown {
    ptrdiff_t first;
    double share[3];
  };
  static thread_local std::vector<Unknown> unknowns;
  unknowns.clear();
  const int* blocks = parameters_.Begin(patch);
  for (int k = 0; k < parameters_.Degree(patch); ++k) {
    const auto& [plus, columns] = directions[k];
    for (int c = 0; c < columns; ++c) {
      Unknown unknown{static_cast<ptrdiff_t>(k) * own, {0, 0, 0}};
      const Eigen::Vector3d direction(plus[c], plus[columns + c], plus[2 * columns + c]);
      if (normal_motion) {
        unknown.share[0] = round_->context().normals[blocks[k]].dot(direction);
      } else {
        std::copy(direction.data(), direction.data() + 3, unknown.share);
      }
      unknowns.push_back(unknown);
    }
  }
  const size_t m = unknowns.size();
  const double scale = beta > 0 ? beta * beta : 1;
  for (size_t i = 0; i < m; ++i) {
    const Unknown& row = unknowns[i];
    gradient[i] = 0;
    for (int c = 0; c < own && beta > 0; ++c) {
      gradient[i] += row.share[c] * own_gradient[row.first + c];
    }
    if (curvature == nullptr) continue;
    for (size_t j = i; j < m; ++j) {
      const Unknown& column = unknowns[j];
      double value = 0;
      for (int c = 0; c < own; ++c) {
        for (int d = 0; d < own; ++d) {
          value += row.share[c] * own_curvature[(row.first + c) * n + column.first + d] *
                   column.share[d];
        }
      }
      curvature[i * m + j] = scale * value;
    }
  }
  return true;
}

std::vector<std::unique_ptr<ceres::CostFunction>> PatchBlocks::MakeCostFunctions() const {
  const auto factors = std::make_shared<std::vector<PatchFactor>>(size());
  factors_ = factors;
  std::vector<std::unique_ptr<ceres::CostFunction>> costs(size());
  ParallelFor(size(), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) costs[k] = std::make_unique<PatchCost>(this, k, factors);
  });
  return costs;
}

void PatchBlocks::FactorForCeres() const {
  const std::shared_ptr<std::vector<PatchFactor>> factors = factors_.lock();
  if (factors == nullptr) return;
  ParallelFor(size(), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      if ((*factors)[k].at != round_->EvaluationCount()) Factor(k, &(*factors)[k]);
    }
  });
}

}  // namespace burin
