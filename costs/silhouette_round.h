// The silhouette term in one round.
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/solve/energy_term.h"
#include "costs/membrane_blocks.h"
#include "costs/silhouette_blocks.h"
#include "costs/silhouette_options.h"
#include "costs/silhouette_view.h"

namespace burin {

class SilhouetteRound : public TermRound, public ceres::EvaluationCallback {
 public:
  SilhouetteRound(const SilhouetteTermOptions& options, const RoundContext& context)
      : options_(options), context_(context) {}

  void AddBlocks(RoundEnergy* energy) override;
  // The vertices of contours.
  void MarkOutlined(std::vector<char>* outlined, std::vector<char>* thin) override;
  void SupportIsKnown() override;
  ceres::EvaluationCallback* Callback() override { return this; }
  int64_t EvaluationCount() const override { return evaluations_; }
  void Forget() override { positions_.clear(); }
  nlohmann::json Report() const override;

  // ceres::EvaluationCallback.
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

 private:
  void FreezeContours();
  void AddMembrane(RoundEnergy* energy);

  const SilhouetteTermOptions options_;
  const RoundContext& context_;
  const std::vector<Eigen::Vector3d>* vertices_ = nullptr;
  std::vector<int> view_;  // of each of views_, in the context's
  std::vector<SilhouetteView> views_;
  std::vector<char> thin_;                      // by vertex: on a part that is thin in some view
  std::vector<std::vector<int>> block_of_rim_;  // by view
  Adjacency edges_;                             // vertices of each block
  std::vector<EdgeSystem> systems_;
  MembraneBlocks* membrane_ = nullptr;      // owned by the round's energy
  std::vector<Eigen::Vector3d> positions_;  // last evaluated
  int64_t evaluations_ = 0;
  double freeze_seconds_ = 0;
  double evaluation_seconds_ = 0;
};

}  // namespace burin
