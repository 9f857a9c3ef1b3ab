// The photometric energy as a function of its cameras: a block of the round's energy for every pair, of both its
// cameras.
//
// Facets have the energy itself (costs/facet_blocks.h), so that of a pair's block is 0; its gradient and curvature are
// those of costs/camera_sums.h, and so is the curvature between vertices and cameras. For Ceres, whose residuals
// have an energy or no gradient, these blocks have all of it (costs/pair_rows.h): one of every pair and vertex, of the vertex
// and both cameras, and one of every pair.
#pragma once

#include "core/solve/energy_blocks.h"
#include "costs/photometric_round.h"

namespace burin {

class CameraPairBlocks : public EnergyBlocks {
 public:
  // `first_camera`: number of the first camera's parameter. The round outlives the blocks.
  CameraPairBlocks(PhotometricRound* round, int first_camera);

  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  const CameraCoupling* Coupling() const override { return &round_->camera_sums().coupling; }

  // Of the facets' energy too.
  CostFunctions MakeCostFunctions() const override;

 private:
  PhotometricRound* round_;
};

}  // namespace burin
