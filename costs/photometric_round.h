// The photometric energy of all selected pairs in a round, evaluated once per point for everybody.
//
//   E_photo = sum_(i,j) sum_p omega_p (1 - ZNCC_p)          (costs/pair_kernel.h)
//
// One call streams the pairs. It leaves, for every corner of every facet, the sums that the cost
// functions of the vertex patches read. With s = 1/depth along the fixed ray of pixel p,
// ds/dV_k = -u_k n^T / offset (core/visibility/facet_pencil.h). So for the pixels y of one corner
//
//   dE/dV_k      = slope[k] n^T           slope[k]        = sum_views -1/offset   sum_y dE/ds u_k
//   H(k, l)      = curvature[k,l] n n^T   curvature[k,l]  = sum_views 1/offset^2  sum_y w D^2 u_k u_l
//   E            = sum cost
//
// with n the facet's area normal at the evaluated positions. H is the majorised Gauss-Newton
// matrix: H - (Gauss-Newton matrix of the windows) is positive semi-definite. Sums are in double,
// fields in single precision unless options ask for double. Held constant during a round: which
// facet each pixel sees, Omega_ij, occlusion masks, window weights.
//
// Where cameras move (RoundParameters::cameras) the rays of a view move with its camera, and an evaluation leaves the
// derivatives by cameras too (costs/camera_sums.h).
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/solve/energy_term.h"
#include "costs/camera_sums.h"
#include "costs/frozen_windows.h"
#include "costs/photometric_options.h"
#include "costs/view_evaluation.h"

namespace burin {

class FacetBlocks;

class PhotometricRound : public TermRound, public ceres::EvaluationCallback {
 public:
  // `view_evaluation` has the images of the context's views. All outlive the round; the options are kept.
  PhotometricRound(const PhotometricOptions& options, bool hold_back_squares,
                   ViewEvaluation* view_evaluation, const RoundContext& context);

  void AddBlocks(RoundEnergy* energy) override;
  void FinishFreeze() override;  // the masks
  // The vertices of facets with a tap of a window that counts, with the cameras of the energy given to
  // AddBlocks. An evaluation, which is remembered.
  void MarkSupported(const std::vector<Eigen::Vector3d>& vertices,
                     std::vector<char>* supported) override;
  ceres::EvaluationCallback* Callback() override { return this; }
  int64_t EvaluationCount() const override { return evaluations_; }
  int64_t WindowCount() const override { return output_.windows; }
  void Forget() override;
  nlohmann::json Report() const override;

  // ceres::EvaluationCallback. Evaluates at the positions of the energy given to AddBlocks. Derivatives are
  // made even when only residuals are asked for: the trust-region solvers ask for them next, at the
  // same point, whenever they accept the step.
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  // Energy at given positions and poses of the cameras (none = those of the context's views); with derivatives
  // fills corner_sums(), and camera_sums() where there are poses. Does nothing when the last call was
  // for the same and had what is asked for.
  double Evaluate(const std::vector<Eigen::Vector3d>& vertices, bool derivatives) {
    return Evaluate(vertices, {}, derivatives);
  }
  double Evaluate(const std::vector<Eigen::Vector3d>& vertices,
                  const std::vector<CameraPose>& poses, bool derivatives);

  // Sums of corner c of facet f at 3 f + c, as of the last Evaluate() with derivatives.
  const CornerSumsList& corner_sums() const { return output_.sums; }
  // Of all pairs, as of the last Evaluate() with derivatives and poses.
  const CameraSums& camera_sums() const { return camera_sums_; }
  // The last evaluated ones.
  const std::vector<CameraPose>& poses() const { return poses_; }
  bool MovesCameras() const { return parameters_ != nullptr && !parameters_->cameras.empty(); }
  // What cost functions of cameras read; made at every evaluation by PrepareForEvaluation() as long as
  // somebody holds it. Cameras move.
  std::shared_ptr<PairRows> MakePairRows();
  // Area normals of the facets at the last evaluated positions.
  const std::vector<Eigen::Vector3d>& facet_normals() const { return normals_; }
  const RoundContext& context() const { return context_; }

  // The scores of all facets at given positions: of the energy's windows or, in rounds whose context
  // holds pairs back, of those held back. Not counted as an evaluation and not remembered: the next
  // Evaluate() is a real one. With derivatives corner_sums() and facet_normals() are left filled.
  enum class Windows { kUsed, kHeldBack };
  std::vector<FacetScore> FacetScores(const std::vector<Eigen::Vector3d>& vertices, Windows windows,
                                      bool derivatives, const std::vector<CameraPose>& poses = {});

  // The same by cell of the reference views, ascending by view and cell.
  std::vector<CellScore> CellScores(const std::vector<Eigen::Vector3d>& vertices, Windows windows);

  const WindowMasks& masks(int view);

 private:
  void SetPoint(const std::vector<Eigen::Vector3d>& vertices, const std::vector<CameraPose>& poses);
  void Score(const std::vector<Eigen::Vector3d>& vertices, Windows windows, bool derivatives,
             const std::vector<CameraPose>& poses);
  void EvaluateSample(const PairSample& sample, bool squares_only, bool derivatives);

  const PhotometricOptions options_;
  const bool hold_back_squares_;
  ViewEvaluation* const view_evaluation_;
  const RoundContext& context_;
  FrozenWindows windows_;
  bool frozen_ = false;  // windows_ is made
  const RoundParameters* parameters_ = nullptr;
  FacetBlocks* blocks_ = nullptr;  // owned by the round's energy

  std::vector<Eigen::Vector3d> positions_;  // last evaluated
  std::vector<CameraPose> poses_;           // likewise; empty where cameras do not move
  std::vector<Camera> cameras_;             // of all views, likewise
  bool have_energy_ = false;
  bool have_derivatives_ = false;
  double energy_ = 0;
  ViewEvaluation::Output output_;
  CameraSums camera_sums_;
  std::weak_ptr<PairRows> pair_rows_;
  int64_t rows_factored_at_ = -1;         // evaluations_
  std::vector<Eigen::Vector3d> normals_;  // area normals of the facets
  int64_t evaluations_ = 0;
  double seconds_ = 0;
};

}  // namespace burin
