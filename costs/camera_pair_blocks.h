// The photometric energy as a function of its cameras: a block of the round's energy for every pair, of both its
// cameras.
//
// Facets have the energy itself (costs/facet_blocks.h), so that of a pair's block is 0; its gradient and curvature are
// those of costs/camera_sums.h, and so is the curvature between vertices and cameras.
#pragma once

#include "core/solve/energy_blocks.h"
#include "costs/photometric_round.h"

namespace burin {

class CameraPairBlocks : public EnergyBlocks {
 public:
  // `first_camera`: number of the first camera's parameter. The round outlives the blocks.
  CameraPairBlocks(const PhotometricRound* round, int first_camera);

  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  const CameraCoupling* Coupling() const override { return &round_->camera_sums().coupling; }

  // Throws InputError: residuals with this gradient and no energy there are none.
  CostFunctions MakeCostFunctions() const override;

 private:
  const PhotometricRound* round_;
};

}  // namespace burin
