#include "costs/patch_cost.h"

#include <algorithm>
#include <utility>

namespace burin {

PatchCost::PatchCost(const PhotometricRound* round, const std::vector<int>& vertices,
                     std::shared_ptr<std::vector<PatchFactor>> factors, size_t index)
    : round_(round), vertices_(vertices), factors_(std::move(factors)), index_(index) {
  int unknowns = 0;
  for (const int v : vertices) unknowns += round->context().Unknowns(v);
  set_num_residuals(unknowns + 1);
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
  size_t first = 0;  // unknown
  for (size_t k = 0; k < vertices_.size(); ++k) {
    const size_t count = context.Unknowns(vertices_[k]);
    const size_t unknown = first;
    first += count;
    if (jacobians[k] == nullptr) continue;
    std::fill(jacobians[k], jacobians[k] + 3 * static_cast<size_t>(rows), 0.0);
    const bool along_normal = context.MovesAlongNormal(vertices_[k]);
    for (size_t u = 0; u < count; ++u) {
      const Eigen::Vector3d direction =
          along_normal ? context.normals[vertices_[k]] : Eigen::Vector3d::Unit(static_cast<int>(u));
      // Column u of L^T is row u of L: entries 0..u, then zeros.
      const double* column = factor + (unknown + u) * (unknown + u + 1) / 2;
      for (size_t row = 0; row <= unknown + u; ++row) {
        for (int c = 0; c < 3; ++c) jacobians[k][3 * row + c] += column[row] * direction[c];
      }
    }
  }
  return true;
}

}  // namespace burin
