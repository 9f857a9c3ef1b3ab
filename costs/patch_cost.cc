#include "costs/patch_cost.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

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

}  // namespace

PatchCost::PatchCost(const PhotometricRound* round, int vertex) : round_(round) {
  const RoundContext& context = round->context();
  blocks_.push_back(vertex);
  for (const int* f = context.faces.Begin(vertex); f != context.faces.End(vertex); ++f) {
    const Eigen::Vector3i& face = context.mesh->faces[*f];
    IncidentFacet incident{*f, 0, {0, 0, 0}};
    for (int c = 0; c < 3; ++c) {
      if (face[c] == vertex) incident.corner = c;
      auto found = std::find(blocks_.begin(), blocks_.end(), face[c]);
      incident.local[c] = static_cast<int>(found - blocks_.begin());
      if (found == blocks_.end()) blocks_.push_back(face[c]);
    }
    facets_.push_back(incident);
  }
  blocks_.shrink_to_fit();
  facets_.shrink_to_fit();
  const int unknowns_per_block = context.motion == Motion::kNormal ? 1 : 3;
  set_num_residuals(unknowns_per_block * static_cast<int>(blocks_.size()) + 1);
  mutable_parameter_block_sizes()->assign(blocks_.size(), 3);
}

int PatchCost::Unknowns() const {
  return (round_->context().motion == Motion::kNormal ? 1 : 3) * static_cast<int>(blocks_.size());
}

PatchSystem PatchCost::System() const {
  const int n = Unknowns();
  PatchSystem system;
  system.gradient.setZero(n);
  system.curvature.setZero(n, n);
  Assemble(&system.cost, system.gradient.data(), system.curvature.data());
  return system;
}

void PatchCost::Assemble(double* cost, double* gradient, double* curvature) const {
  const RoundContext& context = round_->context();
  const bool normal_motion = context.motion == Motion::kNormal;
  const ptrdiff_t n = Unknowns();
  *cost = 0;
  for (const IncidentFacet& incident : facets_) {
    const CornerSums& sums =
        round_->corner_sums()[3 * static_cast<size_t>(incident.facet) + incident.corner];
    const Eigen::Vector3d& normal = round_->facet_normals()[incident.facet];
    *cost += sums.share;
    double along[3] = {0, 0, 0};  // n . N_k
    for (int k = 0; k < 3 && normal_motion; ++k) {
      along[k] = normal.dot(context.normals[blocks_[incident.local[k]]]);
    }
    for (int k = 0; k < 3; ++k) {
      const ptrdiff_t row = incident.local[k];
      if (normal_motion) {
        gradient[row] += sums.slope[k] * along[k];
      } else {
        for (int c = 0; c < 3; ++c) gradient[3 * row + c] += sums.slope[k] * normal[c];
      }
      for (int l = 0; l < 3; ++l) {
        const ptrdiff_t column = incident.local[l];
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

void PatchCost::Linearize() const {
  linearized_at_ = round_->EvaluationCount();
  PatchSystem system = System();
  const auto n = static_cast<int>(system.gradient.size());
  system.curvature.diagonal().array() += Damping(system.curvature.trace(), n);
  const Eigen::LLT<Eigen::MatrixXd> factor(system.curvature);
  valid_ = factor.info() == Eigen::Success;
  if (!valid_) return;
  Eigen::VectorXd r = factor.matrixL().solve(system.gradient);
  const double squared = r.squaredNorm();
  valid_ = std::isfinite(squared + system.cost);  // as where a facet is turned edge-on
  if (!valid_) return;
  const double beta = Beta(squared, system.cost);
  if (beta > 0) {
    r /= beta;
  } else {
    r.setZero();
  }
  const auto rows = static_cast<size_t>(n) + 1;
  linearization_.resize(rows + static_cast<size_t>(n) * (n + 1) / 2);
  std::copy(r.data(), r.data() + n, linearization_.begin());
  linearization_[n] = std::sqrt(std::max(0.0, 2 * system.cost - r.squaredNorm()));
  const double scale = beta > 0 ? beta : 1;
  double* entry = linearization_.data() + rows;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column <= row; ++column) {
      *entry++ = scale * factor.matrixLLT()(row, column);
    }
  }
}

// What Linearize() would find, without derivatives.
bool PatchCost::EvaluateCost(double* cost) const {
  double sum = 0;
  double finite = 0;
  for (const IncidentFacet& incident : facets_) {
    const CornerSums& sums =
        round_->corner_sums()[3 * static_cast<size_t>(incident.facet) + incident.corner];
    const double normal = round_->facet_normals()[incident.facet].squaredNorm();
    sum += sums.share;
    finite += normal * (sums.curvature[0] + sums.curvature[3] + sums.curvature[5]) +
              normal * (sums.slope[0] + sums.slope[1] + sums.slope[2]);
  }
  *cost = std::max(0.0, sum);
  return std::isfinite(sum + finite);
}

bool PatchCost::EvaluateTangent(double const* const* /*parameters*/,
                                const TangentDirections* directions, double* cost, double* gradient,
                                double* curvature) const {
  if (gradient == nullptr) return EvaluateCost(cost);
  static thread_local std::vector<double> scratch;
  const ptrdiff_t n = Unknowns();
  scratch.assign(static_cast<size_t>(2 * n * (n + 1)), 0.0);
  double* const own_gradient = scratch.data();
  double* const own_curvature = own_gradient + n;
  double* const solved = own_curvature + n * n;
  double* const factored = solved + n;
  double sum = 0;
  Assemble(&sum, own_gradient, own_curvature);
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
  *cost = std::max(0.0, sum);

  // From the patch's own unknowns to those of the solve: of each, its block and how it moves that.
  const bool normal_motion = round_->context().motion == Motion::kNormal;
  const int own = normal_motion ? 1 : 3;  // unknowns of a block
  struct Unknown {
    ptrdiff_t first;
    double share[3];
  };
  static thread_local std::vector<Unknown> unknowns;
  unknowns.clear();
  for (size_t k = 0; k < blocks_.size(); ++k) {
    const auto& [plus, columns] = directions[k];
    for (int c = 0; c < columns; ++c) {
      Unknown unknown{static_cast<ptrdiff_t>(k) * own, {0, 0, 0}};
      const Eigen::Vector3d direction(plus[c], plus[columns + c], plus[2 * columns + c]);
      if (normal_motion) {
        unknown.share[0] = round_->context().normals[blocks_[k]].dot(direction);
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

bool PatchCost::Evaluate(double const* const* /*parameters*/, double* residuals,
                         double** jacobians) const {
  if (linearized_at_ != round_->EvaluationCount()) Linearize();
  if (!valid_) return false;
  std::copy(linearization_.begin(), linearization_.begin() + num_residuals(), residuals);
  if (jacobians == nullptr) return true;
  const RoundContext& context = round_->context();
  const int rows = num_residuals();
  const double* factor = linearization_.data() + rows;
  const auto blocks = static_cast<int>(blocks_.size());
  for (int k = 0; k < blocks; ++k) {
    if (jacobians[k] == nullptr) continue;
    // Column u of L^T is row u of L: entries 0..u, then zeros.
    std::fill(jacobians[k], jacobians[k] + 3 * static_cast<size_t>(rows), 0.0);
    if (context.motion == Motion::kNormal) {
      const Eigen::Vector3d& direction = context.normals[blocks_[k]];
      const double* column = factor + static_cast<size_t>(k) * (k + 1) / 2;
      for (int row = 0; row <= k; ++row) {
        for (int c = 0; c < 3; ++c) jacobians[k][3 * row + c] = column[row] * direction[c];
      }
    } else {
      for (int c = 0; c < 3; ++c) {
        const int unknown = 3 * k + c;
        const double* column = factor + static_cast<size_t>(unknown) * (unknown + 1) / 2;
        for (int row = 0; row <= unknown; ++row) jacobians[k][3 * row + c] = column[row];
      }
    }
  }
  return true;
}

}  // namespace burin
