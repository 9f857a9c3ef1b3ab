// The silhouette energy as blocks of the round's energy: one an edge that lies on the contour in some view, of its two
// vertices. Energy, gradient and curvature are the sums of costs/silhouette_view.h over the views. For Ceres, with g and
// H = Q Lambda Q^T of the edge, both in all six coordinates:
//
//   r = [ Lambda^-1/2 Q^T g ; sqrt(2 E - |Lambda^-1/2 Q^T g|^2) ],   J = [ Lambda^1/2 Q^T ; 0 ]
//
// so that 1/2 |r|^2 = E, J^T r = g and J^T J = H.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/solve/energy_blocks.h"

namespace burin {

// Of an edge (a, b), in its coordinates a, b.
struct EdgeSystem {
  double energy = 0;
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> curvature = Eigen::Matrix<double, 6, 6>::Zero();
};

class SilhouetteBlocks : public EnergyBlocks {
 public:
  // `vertices`: two a block. `systems`: of each, where the energy was evaluated last; it outlives the blocks.
  SilhouetteBlocks(Adjacency vertices, const std::vector<EdgeSystem>* systems)
      : EnergyBlocks(std::move(vertices)), systems_(systems) {}

  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  CostFunctions MakeCostFunctions() const override;

 private:
  const std::vector<EdgeSystem>* systems_;
};

}  // namespace burin
