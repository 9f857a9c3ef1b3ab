// The intrinsics' part of the problem that core/cameras/bundle.cc solves: their parameter blocks, residuals through the lens, priors, and
// standard deviations.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/cameras/intrinsics.h"
#include "core/scene/camera_pose.h"
#include "core/scene/scene.h"
#include "core/scene/tracks.h"

namespace burin {

class IntrinsicsSolve {
 public:
  IntrinsicsSolve(const Scene& scene, IntrinsicUnknowns unknowns);

  // `measured`: measurements of every view. Call it before all below.
  void HoldUndetermined(const std::vector<int>& measured);

  bool AreFreeIn(int view) const { return !camera_of_.empty() && camera_of_[view] >= 0; }
  // From where the photograph of such a view has a measurement to where it shows the point: pixels.
  Eigen::Vector2d Offset(const CameraPose& pose, const Eigen::Vector3d& point,
                         const Measurement& measured) const;
  // `scale`: pixels of the photograph that its residual is 1 at.
  void Add(const Measurement& measured, double scale, ceres::LossFunction* loss, CameraPose* pose,
           Eigen::Vector3d* point, ceres::Problem* problem);
  void AddPriors(ceres::Problem* problem, ceres::ParameterBlockOrdering* ordering);
  // After a solve: intrinsics to the cameras.
  void Take(std::vector<Camera>* cameras) const;
  // For Report(), from the curvature of the problem and what is left of its residuals. `others`: its other parameter blocks.
  void FindDeviations(const std::vector<double*>& others, ceres::Problem* problem);
  void Report(std::vector<Lens>* lenses, std::vector<SharedIntrinsics>* shared) const;

 private:
  Eigen::Vector2d Photographed(const Measurement& measured) const;

  std::vector<SharedIntrinsics> shared_;
  std::vector<int> camera_of_;             // of every view: of shared_; -1: it keeps its intrinsics
  std::vector<View> views_;                // without pixels
  std::vector<IntrinsicNumbers> numbers_;  // now, of every camera
  std::vector<IntrinsicNumbers> deviations_;  // px
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;
};

}  // namespace burin
