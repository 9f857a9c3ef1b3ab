// The photometric energy of one vertex patch: cost, gradient, curvature, and what makes residuals of them.
//
// The patch of vertex v is the set of pixels, in all views, whose nearest facet corner (largest barycentric
// coordinate) is v. It depends on v and the vertices of its one-ring facets. It has cost c, gradient g and the
// majorised Gauss-Newton matrix H (costs/photometric_round.h). What it is to a solver:
//
//   E_v = c,   gradient g,   curvature beta^2 (H + delta I),   H + delta I = L L^T
//
// beta = 1 unless |L^-1 g|^2 > 2 c, when beta^2 = |L^-1 g|^2 / (2 c): then no residuals r with 1/2 |r|^2 = c have this
// gradient and a smaller J^T J. The residuals, for Ceres:
//
//   r = [ L^-1 g / beta ; sqrt(2 c - |L^-1 g|^2 / beta^2) ],   J = [ beta L^T ; 0 ]
//
// so that 1/2 |r|^2 = c and J^T r = g exactly and J^T J = beta^2 (H + delta I).
//
// A window gives each of its n taps cost / n, and c is the sum over the patch's pixels of what they got. So
// wherever a window has gradient it has cost too. (With the cost at the window's centre alone, a patch with
// taps and no counted window of its own would have a gradient that no residual can carry: at silhouettes.)
//
// Of a vertex that moves along its normal N_k (RoundContext::MovesAlongNormal) the unknown is the displacement h_k, of
// others all coordinates.
#pragma once

#include <cstdint>
#include <vector>

#include "costs/photometric_round.h"

namespace burin {

// Vertices of the facets of `vertex`, itself first.
void PatchVertices(const RoundContext& context, int vertex, std::vector<int>* vertices);

// c, g and H of a patch in its own unknowns. To be used again for the next patch.
struct PatchSystem {
  std::vector<int> vertices;       // PatchVertices()
  std::vector<int> first_unknown;  // of each, and their number
  double cost = 0;
  std::vector<double> gradient;
  std::vector<double> curvature;  // row-major, both triangles

  // At the round's last evaluation with derivatives.
  void Make(const PhotometricRound& round, int vertex);
  int Unknowns() const { return static_cast<int>(gradient.size()); }
};

// beta^2 and beta^2 delta; not a number where the patch is not finite, as where a facet is turned edge-on.
struct PatchScale {
  double beta_squared = 1;
  double damping = 0;
};
PatchScale ScaleOf(const PatchSystem& system);

// The residuals of a patch, and beta L, its lower triangle row by row.
struct PatchFactor {
  int64_t at = -1;     // the round's EvaluationCount()
  bool valid = false;  // finite
  std::vector<double> values;
};
void Factor(const PatchSystem& system, PatchFactor* result);

}  // namespace burin
