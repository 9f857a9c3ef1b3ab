// A round's energy (core/solve/round_energy.h) as a ceres::Problem, for the minimisers of Ceres. It lives as long as
// one of them runs.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/solve/camera_units.h"
#include "core/solve/round_energy.h"

namespace burin {

class CeresProblem {
 public:
  // `energy` and `callback` (null = none) outlive this.
  CeresProblem(const RoundEnergy& energy, ceres::EvaluationCallback* callback);
  ~CeresProblem();
  CeresProblem(const CeresProblem&) = delete;
  CeresProblem& operator=(const CeresProblem&) = delete;

  // Cameras move in these units instead of those of the energy's manifolds. `units` outlives this.
  void MoveCamerasIn(const CameraUnits& units);

  ceres::Problem* get() const { return problem_.get(); }
  ceres::Problem* operator->() const { return problem_.get(); }
  // Of the terms that `wanted` takes.
  std::vector<ceres::ResidualBlockId> ResidualBlocks(
      const std::function<bool(const std::string& term)>& wanted) const;

 private:
  const RoundEnergy& energy_;
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
  std::vector<std::pair<std::string, std::vector<ceres::ResidualBlockId>>> blocks_;  // by part
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace burin
