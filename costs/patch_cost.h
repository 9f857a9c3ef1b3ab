// The photometric energy of one vertex patch (costs/patch_blocks.h) as a Ceres cost function.
//
// From the patch's cost c, gradient g and majorised Gauss-Newton matrix H it makes
//
//   H + delta I = L L^T
//   r = [ L^-1 g / beta ; sqrt(2 c - |L^-1 g|^2 / beta^2) ],   J = [ beta L^T ; 0 ]
//
// so that 1/2 |r|^2 = c and J^T r = g exactly and J^T J = beta^2 (H + delta I). Any Ceres minimiser can take it from
// there. With Motion::kNormal J = d r / d h_k N_k^T; LineAlongNormal manifolds go with it.
#pragma once

#include <ceres/cost_function.h>

#include <memory>
#include <vector>

#include "costs/patch_blocks.h"

namespace burin {

class PatchCost : public ceres::CostFunction {
 public:
  // `blocks` outlive this. `factors` has one of every patch; what is missing in it is made where it is asked for.
  PatchCost(const PatchBlocks* blocks, int patch,
            std::shared_ptr<std::vector<PatchFactor>> factors);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PatchBlocks* blocks_;
  const int patch_;
  // A residual block is evaluated by one thread at a time.
  const std::shared_ptr<std::vector<PatchFactor>> factors_;
};

}  // namespace burin
