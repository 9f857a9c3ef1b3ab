// The photometric energy of one vertex patch as a Ceres cost function.
//
// The patch of vertex v is the set of pixels, in all views, whose nearest facet corner (largest
// barycentric coordinate) is v. Its parameter blocks are v and the vertices of its one-ring facets. From
// the patch's cost c, gradient g and majorised Gauss-Newton matrix H (costs/photometric_round.h) it
// makes
//
//   H + delta I = L L^T
//   r = [ L^-1 g / beta ; sqrt(2 c - |L^-1 g|^2 / beta^2) ],   J = [ beta L^T ; 0 ]
//
// so that 1/2 |r|^2 = c and J^T r = g exactly and J^T J = beta^2 (H + delta I). beta = 1 unless
// |L^-1 g|^2 > 2 c, when beta^2 = |L^-1 g|^2 / (2 c). Any Ceres minimiser can take it from there.
//
// A window gives each of its n taps cost / n, and c is the sum over the patch's pixels of what they got. So
// wherever a window has gradient it has cost too. (With the cost at the window's centre alone, a patch with
// taps and no counted window of its own would have a gradient that no residual can carry: at silhouettes.)
//
// With Motion::kNormal the system is formed in the displacements h_k along the vertex normals N_k, and
// J = d r / d h_k N_k^T. LineAlongNormal manifolds go with it. With kFree it is formed in all coordinates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/solve/tangent_cost.h"
#include "costs/photometric_round.h"

namespace burin {

// Cost, gradient and majorised Gauss-Newton matrix of a patch in its own unknowns: K displacements
// (kNormal) or 3 K coordinates (kFree), K = number of blocks.
struct PatchSystem {
  double cost = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd curvature;
};

class PatchCost : public TangentCost {
 public:
  // The round must outlive the cost. `vertex` must have a facet.
  PatchCost(const PhotometricRound* round, int vertex);

  // Vertices in the order of the parameter blocks; the first is the patch's own.
  const std::vector<int>& blocks() const { return blocks_; }
  PatchSystem System() const;
  // Factors the system at the round's last evaluation with derivatives, for Evaluate(), which does so itself
  // where nobody has. The round calls this for all patches in parallel before Ceres, which evaluates on one
  // thread, reads them.
  void Linearize() const;
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
  bool EvaluateTangent(double const* const* parameters, const TangentDirections* directions,
                       double* cost, double* gradient, double* curvature) const override;
  void ExpectResiduals(bool on) override { expects_residuals_ = on; }
  bool ExpectsResiduals() const { return expects_residuals_; }

 private:
  struct IncidentFacet {
    int facet;
    int corner;    // of the patch's vertex
    int local[3];  // block index of each corner
  };
  int Unknowns() const;
  // What PatchSystem has; `gradient` and `curvature` (both triangles) begin as zeros.
  void Assemble(double* cost, double* gradient, double* curvature) const;
  bool EvaluateCost(double* cost) const;

  const PhotometricRound* round_;
  std::vector<int> blocks_;
  std::vector<IncidentFacet> facets_;
  bool expects_residuals_ = false;
  // Of Linearize(); a residual block is evaluated by one thread at a time.
  mutable int64_t linearized_at_ = -1;  // the round's EvaluationCount()
  mutable bool valid_ = false;
  // The residuals, then beta L, its lower triangle row by row.
  mutable std::vector<double> linearization_;
};

}  // namespace burin
