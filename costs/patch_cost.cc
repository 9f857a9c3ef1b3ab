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

PatchSystem PatchCost::System() const {
  const RoundContext& context = round_->context();
  const bool normal_motion = context.motion == Motion::kNormal;
  const int n = (normal_motion ? 1 : 3) * static_cast<int>(blocks_.size());
  PatchSystem system;
  system.gradient.setZero(n);
  system.curvature.setZero(n, n);
  for (const IncidentFacet& incident : facets_) {
    const CornerSums& sums = round_->corner_sums()[3 * incident.facet + incident.corner];
    const Eigen::Vector3d& normal = round_->facet_normals()[incident.facet];
    system.cost += sums.share;
    double along[3];  // n . N_k
    for (int k = 0; k < 3 && normal_motion; ++k) {
      along[k] = normal.dot(context.normals[blocks_[incident.local[k]]]);
    }
    for (int k = 0; k < 3; ++k) {
      const int row = incident.local[k];
      if (normal_motion) {
        system.gradient[row] += sums.slope[k] * along[k];
      } else {
        system.gradient.segment<3>(3 * row) += sums.slope[k] * normal;
      }
      for (int l = 0; l < 3; ++l) {
        const int column = incident.local[l];
        const double curvature = sums.curvature[kPacked[k][l]];
        if (normal_motion) {
          system.curvature(row, column) += curvature * along[k] * along[l];
        } else {
          system.curvature.block<3, 3>(3 * row, 3 * column) +=
              curvature * normal * normal.transpose();
        }
      }
    }
  }
  return system;
}

void PatchCost::Linearize() {
  PatchSystem system = System();
  const auto n = static_cast<int>(system.gradient.size());
  const double damping =
      kRelativeDamping * system.curvature.trace() / static_cast<double>(n) + kAbsoluteDamping;
  system.curvature.diagonal().array() += damping;
  const Eigen::LLT<Eigen::MatrixXd> factor(system.curvature);
  valid_ = factor.info() == Eigen::Success;
  if (!valid_) return;
  Eigen::VectorXd r = factor.matrixL().solve(system.gradient);
  const double squared = r.squaredNorm();
  valid_ = std::isfinite(squared + system.cost);  // as where a facet is turned edge-on
  if (!valid_) return;
  double beta = 1;
  if (squared > 2 * system.cost) {
    if (system.cost <= 0) {  // by rounding: its windows agree
      r.setZero();
    } else {
      beta = std::sqrt(squared / (2 * system.cost));
      r /= beta;
    }
  }
  const auto rows = static_cast<size_t>(n) + 1;
  linearization_.resize(rows + static_cast<size_t>(n) * (n + 1) / 2);
  std::copy(r.data(), r.data() + n, linearization_.begin());
  linearization_[n] = std::sqrt(std::max(0.0, 2 * system.cost - r.squaredNorm()));
  double* entry = linearization_.data() + rows;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column <= row; ++column) {
      *entry++ = beta * factor.matrixLLT()(row, column);
    }
  }
}

bool PatchCost::Evaluate(double const* const* /*parameters*/, double* residuals,
                         double** jacobians) const {
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
