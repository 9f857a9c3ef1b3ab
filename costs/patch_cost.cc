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

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

PatchCost::PatchCost(const PhotometricEnergy* energy, int vertex) : energy_(energy) {
  const RoundContext& context = energy->context();
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
  const int unknowns_per_block = context.motion == Motion::kNormal ? 1 : 3;
  set_num_residuals(unknowns_per_block * static_cast<int>(blocks_.size()) + 1);
  mutable_parameter_block_sizes()->assign(blocks_.size(), 3);
}

PatchSystem PatchCost::System() const {
  const RoundContext& context = energy_->context();
  const bool normal_motion = context.motion == Motion::kNormal;
  const int n = (normal_motion ? 1 : 3) * static_cast<int>(blocks_.size());
  PatchSystem system;
  system.gradient.setZero(n);
  system.curvature.setZero(n, n);
  for (const IncidentFacet& incident : facets_) {
    const CornerSums& sums = energy_->corner_sums()[3 * incident.facet + incident.corner];
    const Eigen::Vector3d& normal = energy_->facet_normals()[incident.facet];
    system.cost += sums.cost;
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

bool PatchCost::Evaluate(double const* const* /*parameters*/, double* residuals,
                         double** jacobians) const {
  const RoundContext& context = energy_->context();
  PatchSystem system = System();
  const auto n = static_cast<int>(system.gradient.size());
  const double damping =
      kRelativeDamping * system.curvature.trace() / static_cast<double>(n) + kAbsoluteDamping;
  system.curvature.diagonal().array() += damping;
  const Eigen::LLT<Eigen::MatrixXd> factor(system.curvature);
  if (factor.info() != Eigen::Success) return false;
  Eigen::VectorXd r = factor.matrixL().solve(system.gradient);
  const double squared = r.squaredNorm();
  double beta = 1;
  if (squared > 2 * system.cost) {
    // A patch may have gradient from windows centred in its neighbours and no window of its own.
    if (system.cost <= 0) {
      r.setZero();
    } else {
      beta = std::sqrt(squared / (2 * system.cost));
      r /= beta;
    }
  }
  Eigen::Map<Eigen::VectorXd>(residuals, n) = r;
  residuals[n] = std::sqrt(std::max(0.0, 2 * system.cost - r.squaredNorm()));
  if (jacobians == nullptr) return true;
  const auto blocks = static_cast<int>(blocks_.size());
  for (int k = 0; k < blocks; ++k) {
    if (jacobians[k] == nullptr) continue;
    Eigen::Map<RowMajorMatrix> jacobian(jacobians[k], n + 1, 3);
    jacobian.setZero();
    if (context.motion == Motion::kNormal) {
      const Eigen::Vector3d& direction = context.normals[blocks_[k]];
      // L^T is upper triangular: rows up to k are non-zero.
      for (int row = 0; row <= k; ++row) {
        jacobian.row(row) = beta * factor.matrixLLT()(k, row) * direction.transpose();
      }
    } else {
      for (int c = 0; c < 3; ++c) {
        for (int row = 0; row <= 3 * k + c; ++row) {
          jacobian(row, c) = beta * factor.matrixLLT()(3 * k + c, row);
        }
      }
    }
  }
  return true;
}

}  // namespace burin
