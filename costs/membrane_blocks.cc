#include "costs/membrane_blocks.h"

#include <cmath>
#include <memory>

#include "costs/stencil_cost.h"

namespace burin {

MembraneBlocks::MembraneBlocks(Adjacency vertices, double weight, double pixel,
                               const std::vector<Eigen::Vector3d>& rest,
                               const std::vector<Eigen::Vector3d>* positions)
    : EnergyBlocks(std::move(vertices)),
      stiffness_(size(), weight / (pixel * pixel)),
      positions_(positions) {
  rest_.reserve(size());
  for (int k = 0; k < size(); ++k) {
    const int* v = parameters_.Begin(k);
    rest_.push_back(rest[v[0]] - rest[v[1]]);
  }
}

bool MembraneBlocks::Evaluate(int k, const TangentDirections* directions, double* energy,
                              double* gradient, double* curvature) const {
  const int* v = parameters_.Begin(k);
  const Eigen::Vector3d apart = (*positions_)[v[0]] - (*positions_)[v[1]] - rest_[k];
  *energy = 0.5 * stiffness_[k] * apart.squaredNorm();
  if (gradient == nullptr) return true;
  Eigen::Vector3d columns[6];
  int count = 0;
  for (int p = 0; p < 2; ++p) {
    const auto& [plus, unknowns] = directions[p];
    for (int u = 0; u < unknowns; ++u) {
      columns[count++] =
          (p == 0 ? 1 : -1) * Eigen::Vector3d(plus[u], plus[unknowns + u], plus[2 * unknowns + u]);
    }
  }
  for (int i = 0; i < count; ++i) {
    gradient[i] = stiffness_[k] * columns[i].dot(apart);
    if (curvature == nullptr) continue;
    for (int j = i; j < count; ++j) {
      curvature[i * count + j] = stiffness_[k] * columns[i].dot(columns[j]);
    }
  }
  return true;
}

CostFunctions MembraneBlocks::MakeCostFunctions() const {
  CostFunctions made;
  made.parameters = parameters_;
  made.costs.reserve(size());
  for (int k = 0; k < size(); ++k) {
    made.costs.push_back(std::make_unique<StencilCost>(std::vector<double>{1, -1},
                                                       std::sqrt(stiffness_[k]), rest_[k]));
  }
  return made;
}

}  // namespace burin
