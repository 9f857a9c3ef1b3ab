// Units of cameras for minimisers that take one step length for all unknowns.
//
// A turn of a view by one radian and a vertex' move by one pixel are as far apart in curvature as f^2 times the view's
// pixels. In the units d of a camera, z = U d in those of its manifold,
//
//   U = sqrt(m) L^-T,   K_cc + D = L L^T     =>     U^T (K_cc + D) U = m I
//
// a camera alone has the curvature m, the mean over the vertices' unknowns, along every direction. K_cc is its block of
// the Gauss-Newton matrix at the round's start, D a share of the median over the cameras
// (solver.camera_damping), so that views which the photographs hardly hold are not moved the farther for it.
#pragma once

#include <ceres/evaluation_callback.h>
#include <ceres/manifold.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/solve/round_energy.h"

namespace burin {

class CameraUnits {
 public:
  // At the current values; `callback` prepares the energy, null if it need not be. Both and the energy's
  // manifolds outlive this.
  CameraUnits(const RoundEnergy& energy, ceres::EvaluationCallback* callback, double damping);

  // A camera's manifold in its units; null where it does not move.
  ceres::Manifold* Of(int camera) const { return manifolds_[camera].get(); }
  // m
  double curvature() const { return curvature_; }

 private:
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;  // of each camera
  double curvature_ = 1;
};

}  // namespace burin
