// The photometric energy as blocks of the round's energy: one a facet, of its three vertices.
//
// A facet has the sums of its corners' pixels (costs/photometric_round.h): slopes by its vertices, curvatures by pairs
// of them. With d_u the direction in which unknown u moves vertex k, and beta^2, delta those of a corner's patch
// (costs/patch_system.h):
//
//   E_f       = sum_c share_c
//   g_u       = sum_c slope_c[k] n . d_u
//   H_uw      = sum_c beta_c^2 curvature_c[k,l] (n . d_u) (n . d_w)  +  [k = l] sum_c beta_c^2 delta_c / m_ck d_u . d_w
//
// m_ck: facets that corner c and vertex k share, over which the patch's delta I is spread. Summed over the facets these
// are the energy, gradient and curvature of all patches: those of the cost functions that Ceres gets. A vertex is in
// six facets of three vertices, and would be in seven patches of seven.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/solve/energy_blocks.h"
#include "costs/patch_system.h"
#include "costs/photometric_round.h"

namespace burin {

class FacetBlocks : public EnergyBlocks {
 public:
  // Of the vertices that the round's context has as `seen`. The round outlives the blocks.
  explicit FacetBlocks(const PhotometricRound* round);

  void Prepare(bool curvature) override;
  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;

  // One patch of every vertex; none where cameras move (costs/camera_pair_blocks.h has the energy then).
  CostFunctions MakeCostFunctions() const override;
  // Factors all patches in parallel where there are cost functions of them: Ceres evaluates these on one thread.
  void FactorForCeres() const;

 private:
  FacetBlocks(const PhotometricRound* round, std::vector<int> facets);

  const PhotometricRound* round_;
  std::vector<int> facet_;                       // of each block
  std::vector<std::array<uint8_t, 3>> sharing_;  // of its edges (0,1), (1,2), (2,0): facets there
  std::vector<PatchScale> scales_;               // by vertex
  int64_t scaled_at_ = -1;                       // the round's EvaluationCount()
  mutable std::weak_ptr<std::vector<PatchFactor>> factors_;  // of the cost functions that there are
};

}  // namespace burin
