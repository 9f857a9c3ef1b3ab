// The photometric energy by vertex patch.
//
// The patch of vertex v is the set of pixels, in all views, whose nearest facet corner (largest barycentric
// coordinate) is v. Its parameter blocks are v and the vertices of its one-ring facets. It has cost c, gradient g and
// the majorised Gauss-Newton matrix H (costs/photometric_round.h). What it is to a solver:
//
//   E_v = c,   gradient g,   curvature beta^2 (H + delta I)
//
// beta = 1 unless |L^-1 g|^2 > 2 c with H + delta I = L L^T, when beta^2 = |L^-1 g|^2 / (2 c): then no residuals r
// with 1/2 |r|^2 = c have this gradient and a smaller J^T J. costs/patch_cost.h are these residuals, for Ceres.
//
// A window gives each of its n taps cost / n, and c is the sum over the patch's pixels of what they got. So
// wherever a window has gradient it has cost too. (With the cost at the window's centre alone, a patch with
// taps and no counted window of its own would have a gradient that no residual can carry: at silhouettes.)
//
// With Motion::kNormal the system is formed in the displacements h_k along the vertex normals N_k. With kFree it is
// formed in all coordinates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/solve/energy_blocks.h"
#include "costs/photometric_round.h"

namespace burin {

// Cost, gradient and majorised Gauss-Newton matrix of a patch in its own unknowns: K displacements
// (kNormal) or 3 K coordinates (kFree), K = number of its parameter blocks.
struct PatchSystem {
  double cost = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd curvature;
};

// The residuals of a patch at an evaluation of the round, and beta L, its lower triangle row by row.
struct PatchFactor {
  int64_t at = -1;     // the round's EvaluationCount()
  bool valid = false;  // finite
  std::vector<double> values;
};

class PatchBlocks : public EnergyBlocks {
 public:
  // The round must outlive the blocks; every one of `vertices` must have a facet. A patch's first parameter block is
  // its own vertex.
  PatchBlocks(const PhotometricRound* round, const std::vector<int>& vertices);

  const PhotometricRound& round() const { return *round_; }
  int VertexOf(int patch) const { return *parameters_.Begin(patch); }
  int Unknowns(int patch) const;
  PatchSystem System(int patch) const;
  // The system at the round's last evaluation with derivatives, as residuals.
  void Factor(int patch, PatchFactor* factor) const;

  bool Evaluate(int patch, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  std::vector<std::unique_ptr<ceres::CostFunction>> MakeCostFunctions() const override;
  // Factors all patches in parallel where there are cost functions of them: Ceres evaluates these on one thread.
  void FactorForCeres() const;

 private:
  // Of a facet of the patch's vertex, in the order of RoundContext::faces: which parameter block each corner is.
  struct Corners {
    uint16_t block[3];
  };
  // What PatchSystem has; `gradient` and `curvature` (both triangles) begin as zeros.
  void Assemble(int patch, double* cost, double* gradient, double* curvature) const;
  bool EvaluateCost(int patch, double* cost) const;

  const PhotometricRound* round_;
  std::vector<int> first_corners_;  // of each patch
  std::vector<Corners> corners_;
  mutable std::weak_ptr<std::vector<PatchFactor>> factors_;  // of the cost functions that there are
};

}  // namespace burin
