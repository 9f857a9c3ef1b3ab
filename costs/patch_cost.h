// The photometric energy of one vertex patch as a Ceres cost function: the residuals and the Jacobian of
// costs/patch_system.h. Of a vertex that moves along its normal J = d r / d h_k N_k^T; a LineAlongNormal manifold goes with it.
#pragma once

#include <ceres/cost_function.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "costs/patch_system.h"

namespace burin {

class PatchCost : public ceres::CostFunction {
 public:
  // `vertices` of the patch, its own first. The round outlives this. `factors` has this patch's at `index`; what is
  // missing there is made where it is asked for.
  PatchCost(const PhotometricRound* round, const std::vector<int>& vertices,
            std::shared_ptr<std::vector<PatchFactor>> factors, size_t index);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PhotometricRound* round_;
  const std::vector<int> vertices_;
  // A residual block is evaluated by one thread at a time.
  const std::shared_ptr<std::vector<PatchFactor>> factors_;
  const size_t index_;
};

}  // namespace burin
