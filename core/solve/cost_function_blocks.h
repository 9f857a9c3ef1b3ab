// Energy blocks that are cost functions of Ceres: what RoundEnergy::Add collects.
#pragma once

#include <memory>
#include <vector>

#include "core/solve/energy_blocks.h"
#include "core/solve/round_energy.h"

namespace burin {

class CostFunctionBlocks : public EnergyBlocks {
 public:
  // `energy`, which numbers the parameters, outlives this.
  explicit CostFunctionBlocks(const RoundEnergy* energy)
      : EnergyBlocks({{0}, {}}), energy_(energy) {}
  void Append(std::unique_ptr<ceres::CostFunction> cost, std::unique_ptr<ceres::LossFunction> loss,
              const std::vector<int>& parameters);

  // With residuals r, their Jacobian J in the unknowns and s = |r|^2: 1/2 rho(s), rho'(s) J^T r, rho'(s) J^T J.
  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  CostFunctions MakeCostFunctions() const override;

 private:
  const RoundEnergy* energy_;
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses_;  // null = none
};

}  // namespace burin
