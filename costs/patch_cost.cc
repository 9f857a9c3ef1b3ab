#include "costs/patch_cost.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace burin {

PatchCost::PatchCost(const PatchBlocks* blocks, int patch,
                     std::shared_ptr<std::vector<PatchFactor>> factors)
    : blocks_(blocks), patch_(patch), factors_(std::move(factors)) {
  set_num_residuals(blocks->Unknowns(patch) + 1);
  mutable_parameter_block_sizes()->assign(blocks->parameters().Degree(patch), 3);
}

bool PatchCost::Evaluate(double const* const* /*parameters*/, double* residuals,
                         double** jacobians) const {
  PatchFactor& made = (*factors_)[patch_];
  if (made.at != blocks_->round().EvaluationCount()) blocks_->Factor(patch_, &made);
  if (!made.valid) return false;
  std::copy(made.values.begin(), made.values.begin() + num_residuals(), residuals);
  if (jacobians == nullptr) return true;
  const RoundContext& context = blocks_->round().context();
  const int rows = num_residuals();
  const double* factor = made.values.data() + rows;
  const Adjacency& vertices = blocks_->parameters();
  const int blocks = vertices.Degree(patch_);
  for (int k = 0; k < blocks; ++k) {
    if (jacobians[k] == nullptr) continue;
    // Column u of L^T is row u of L: entries 0..u, then zeros.
    std::fill(jacobians[k], jacobians[k] + 3 * static_cast<size_t>(rows), 0.0);
    if (context.motion == Motion::kNormal) {
      const Eigen::Vector3d& direction = context.normals[vertices.Begin(patch_)[k]];
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
