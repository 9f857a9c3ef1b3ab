// The photometric energy of all selected pairs, evaluated once per point for everybody.
//
//   E_photo = sum_(i,j) sum_p omega_p (1 - ZNCC_p)          (costs/pair_kernel.h)
//
// One call streams the pairs and leaves, for every corner of every facet, the sums that the cost
// functions of the vertex patches read. With s = 1/depth along the fixed ray of pixel p,
// ds/dV_k = -u_k n^T / offset (core/facet_pencil.h), so that for the pixels y of one
// corner
//
//   dE/dV_k      = slope[k] n^T           slope[k]        = sum_views -1/offset   sum_y dE/ds u_k
//   H(k, l)      = curvature[k,l] n n^T   curvature[k,l]  = sum_views 1/offset^2  sum_y w D^2 u_k u_l
//   E            = sum cost
//
// with n the facet's area normal at the evaluated positions. H is the majorised Gauss-Newton
// matrix: H - (Gauss-Newton matrix of the windows) is positive semi-definite. Sums are in double,
// fields in single precision unless options ask for double. Held constant during a round: which
// facet each pixel sees, Omega_ij, occlusion masks, window weights.
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "core/energy_term.h"
#include "core/options.h"
#include "costs/occlusion_mask.h"

namespace burin {

struct PhotometricOptions {
  int window = 5;                 // taps along a side, odd
  double variance_floor = 25;     // e^2 in squared grey levels
  double reliability = 0;         // nu = reliability * (noise_i^2 + noise_j^2)
  double min_valid_share = 0.8;   // of the window's taps
  bool double_precision = false;  // fields in double, for derivative checks
  MaskOptions mask;
  void Describe(OptionSet* set);
};

// Sums over the pixels of one corner of one facet (see above).
struct CornerSums {
  double cost = 0;
  double slope[3] = {0, 0, 0};
  double curvature[6] = {0, 0, 0, 0, 0, 0};  // (0,0) (0,1) (0,2) (1,1) (1,2) (2,2)
};

// Sums over the windows centred in one facet, of all pairs.
struct FacetScore {
  double cost = 0;    // sum of omega (1 - z)
  double weight = 0;  // sum of omega
};

class PhotometricEnergy : public EnergyTerm, public ceres::EvaluationCallback {
 public:
  explicit PhotometricEnergy(const PhotometricOptions& options);
  ~PhotometricEnergy() override;

  std::string Name() const override { return "photometric"; }
  void BeginLevel(const std::vector<LevelView>& views) override;
  void BeginRound(const RoundContext& context) override;
  void Freeze() override;  // the masks; the first evaluation makes up for it
  void AddResiduals(ceres::Problem* problem, std::vector<Eigen::Vector3d>* vertices) override;
  ceres::EvaluationCallback* Callback() override { return this; }
  int64_t EvaluationCount() const override;
  void Forget() override;
  nlohmann::json RoundReport() const override;

  // ceres::EvaluationCallback. Evaluates at the positions given to AddResiduals. Derivatives are
  // made even when only residuals are asked for: the trust-region solvers ask for them next, at the
  // same point, whenever they accept the step.
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  // Energy at given positions; with derivatives fills corner_sums(). Does nothing when the last
  // call was for the same positions and had what is asked for.
  double Evaluate(const std::vector<Eigen::Vector3d>& vertices, bool derivatives);

  // Sums of corner c of facet f at 3 f + c, as of the last Evaluate() with derivatives.
  const std::vector<CornerSums>& corner_sums() const;
  // Area normals of the facets at the last evaluated positions.
  const std::vector<Eigen::Vector3d>& facet_normals() const;
  const RoundContext& context() const;

  // Leaves out, from the next round on, the pixels of small squares spread over every reference
  // view: data held back to judge the result by (costs/held_back.h).
  void HoldBackSquares(bool hold);

  // The scores of all facets at given positions; of the windows centred in those squares alone, or
  // of all. Not remembered: the next Evaluate() is a real one.
  std::vector<FacetScore> FacetScores(const std::vector<Eigen::Vector3d>& vertices,
                                      bool squares_only);

  int64_t valid_windows() const;             // windows that counted in the last evaluation
  const WindowMasks& masks(int view) const;  // of the round

 private:
  template <typename T>
  struct State;
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace burin
