// The energy of a round: what it is a function of, and what its terms made of it.
//
// Parameter blocks are numbered: those of the RoundParameters first, then what a term brings of its own. Terms add
// their blocks (core/solve/energy_blocks.h); then whoever builds the round says which parameters are constant and on
// which manifold the others move. burin's own minimisers take it as it is. core/solve/ceres_problem.h is the same energy for
// those of Ceres.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/scene/camera_pose.h"
#include "core/solve/energy_blocks.h"

namespace burin {

class CostFunctionBlocks;

// What a round solves for. Addresses stay during the round. A new kind of unknown is a new field, numbered by
// RoundEnergy's constructor, its manifolds set in core/refine/frozen_round.cc.
struct RoundParameters {
  std::vector<Eigen::Vector3d>
      vertices;  // normalised world; blocks of size 3, numbered as they are
  // Of all views of the round's context, in its world; blocks of size 7, numbered after the vertices. Empty: the
  // cameras of the views as they are, and nothing is computed for them.
  std::vector<CameraPose> cameras = {};
};

class RoundEnergy {
 public:
  // `parameters` outlives this.
  explicit RoundEnergy(RoundParameters* parameters);
  ~RoundEnergy();
  RoundEnergy(const RoundEnergy&) = delete;
  RoundEnergy& operator=(const RoundEnergy&) = delete;

  RoundParameters& parameters() const { return *parameters_; }

  // Terms. What is added belongs to the term that was begun last.
  void BeginTerm(const std::string& name);
  void Add(std::unique_ptr<EnergyBlocks> blocks);
  // One block, 1/2 rho(|r|^2) of a cost function's residuals r; `loss` may be null (rho(s) = s). `parameters`
  // point at the first coordinates, each block once; those that are not of the RoundParameters are new ones of the
  // size that the cost function says. burin's own minimisers take rho'(s) J^T J for the curvature.
  void Add(std::unique_ptr<ceres::CostFunction> cost, std::unique_ptr<ceres::LossFunction> loss,
           const std::vector<double*>& parameters);

  struct Part {
    std::string term;
    std::unique_ptr<EnergyBlocks> blocks;
  };
  // In the order in which they were added. Cost functions that a term adds one after the other are one part.
  const std::vector<Part>& parts() const { return parts_; }

  // Parameter blocks.
  int ParameterCount() const;
  // That of the first camera; they end CameraCount() later.
  int FirstCamera() const { return static_cast<int>(parameters_->vertices.size()); }
  int CameraCount() const { return static_cast<int>(parameters_->cameras.size()); }
  bool IsCamera(int parameter) const {
    return parameter >= FirstCamera() && parameter < FirstCamera() + CameraCount();
  }
  double* Values(int parameter) const;
  int Size(int parameter) const;
  int TangentSize(int parameter) const;
  void SetConstant(int parameter);
  bool IsConstant(int parameter) const { return constant_[parameter] != 0; }
  // It outlives this; null = every coordinate moves.
  void SetManifold(int parameter, ceres::Manifold* manifold);
  ceres::Manifold* ManifoldOf(int parameter) const { return manifolds_[parameter]; }
  // Those that some block has, ascending; and of these the ones that are not constant.
  std::vector<int> Used() const;
  std::vector<int> Moving() const;

  // Sum over the blocks of a term where the parameters are now, added up in their order whatever the number of
  // threads; NaN when one has no finite value. No evaluation callback is called: terms that have one must have been
  // prepared here.
  double EnergyOf(const std::string& term) const;

 private:
  struct Extra {  // a term's own parameter block
    double* values;
    int size;
  };
  int NumberOf(double* values, int size);
  int FirstExtra() const { return FirstCamera() + CameraCount(); }

  RoundParameters* const parameters_;
  std::vector<Extra> extras_;
  std::unordered_map<const double*, int> extra_numbers_;
  std::vector<char> constant_;
  std::vector<ceres::Manifold*> manifolds_;
  std::string term_;
  CostFunctionBlocks* open_ = nullptr;  // the last part, when it takes cost functions
  std::vector<Part> parts_;
};

}  // namespace burin
