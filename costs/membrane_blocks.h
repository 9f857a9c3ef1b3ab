// A membrane on displacements, as blocks of the energy: one an edge (a, b).
//
//   E = w/2 |d_a - d_b|^2,   d = (V - rest) / pixel
//
// It moves neighbours alike. Their shape and place cost nothing, so it neither shrinks nor flattens, whatever is thin.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/solve/energy_blocks.h"

namespace burin {

class MembraneBlocks : public EnergyBlocks {
 public:
  // `vertices`: two a block; `rest`, `positions`: of all vertices, these read where an evaluation needs them; they outlive
  // this. All edges have the weight, those of SetIdle none.
  MembraneBlocks(Adjacency vertices, double weight, double pixel,
                 const std::vector<Eigen::Vector3d>& rest,
                 const std::vector<Eigen::Vector3d>* positions);
  void SetIdle(int k) { stiffness_[k] = 0; }

  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  CostFunctions MakeCostFunctions() const override;

 private:
  std::vector<double> stiffness_;      // w / pixel^2
  std::vector<Eigen::Vector3d> rest_;  // V_a - V_b
  const std::vector<Eigen::Vector3d>* positions_;
};

}  // namespace burin
