#include "costs/patch_cost.h"

#include <algorithm>
#include <utility>

namespace burin {

PatchCost::PatchCost(const PhotometricRound* round, const std::vector<int>& vertices,
                     std::shared_ptr<std::vector<PatchFactor>> factors, size_t index)
    : round_(round), vertices_(vertices), factors_(std::move(factors)), index_(index) {
  const int own = round->context().motion == Motion::kNormal ? 1 : 3;
  set_num_residuals(own * static_cast<int>(vertices.size()) + 1);
  mutable_parameter_block_sizes()->assign(vertices.size(), 3);
}

bool PatchCost::Evaluate(double const* const* /*parameters*/, double* residuals,
                         double** jacobians) const {
  PatchFactor& made = (*factors_)[index_];
  if (made.at != round_->EvaluationCount()) {
    PatchSystem system;
    system.Make(*round_, vertices_[0]);
    Factor(system, &made);
    made.at = round_->EvaluationCount();
  }
  if (!made.valid) return false;
  std::copy(made.values.begin(), made.values.begin() + num_residuals(), residuals);
  if (jacobians == nullptr) return true;
  const RoundContext& context = round_->context();
  const int rows = num_residuals();
  const double* factor = made.values.data() + rows;
  for (size_t k = 0; k < vertices_.size(); ++k) {
    if (jacobians[k] == nullptr) continue;
    // Column u of L^T is row u of L: entries 0..u, then zeros.
    std::fill(jacobians[k], jacobians[k] + 3 * static_cast<size_t>(rows), 0.0);
    if (context.motion == Motion::kNormal) {
      const Eigen::Vector3d& direction = context.normals[vertices_[k]];
      const double* column = factor + k * (k + 1) / 2;
      for (size_t row = 0; row <= k; ++row) {
        for (int c = 0; c < 3; ++c) jacobians[k][3 * row + c] = column[row] * direction[c];
      }
    } else {
      for (size_t c = 0; c < 3; ++c) {
        const size_t unknown = 3 * k + c;
        const double* column = factor + unknown * (unknown + 1) / 2;
        for (size_t row = 0; row <= unknown; ++row) jacobians[k][3 * row + c] = column[row];
      }
    }
  }
  return true;
}

}  // namespace burin
