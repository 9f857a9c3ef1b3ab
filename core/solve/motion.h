// How the unknowns of a round move, as manifolds of Ceres.
#pragma once

#include <ceres/manifold.h>
#include <ceres/product_manifold.h>

#include <Eigen/Core>

namespace burin {

// A camera (core/scene/camera_pose.h): Plus(pose, d) turns it by R <- Exp(2 d_0..2) R and moves its centre by d_3..5.
// (A turn by the rotation vector w is Ceres' quaternion step w / 2.)
using PoseManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

// A vertex along one fixed direction.
//
//   Plus(x, h) = x + h N,  Minus(y, x) = N . (y - x),  N a unit vector fixed for the round
//
// "The surface evolves along its normal" (Romanoni & Matteucci, section 3): one degree of freedom.
class LineAlongNormal : public ceres::Manifold {
 public:
  explicit LineAlongNormal(const Eigen::Vector3d& direction) : direction_(direction) {}
  int AmbientSize() const override { return 3; }
  int TangentSize() const override { return 1; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    for (int c = 0; c < 3; ++c) x_plus_delta[c] = x[c] + delta[0] * direction_[c];
    return true;
  }
  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    for (int c = 0; c < 3; ++c) jacobian[c] = direction_[c];
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    y_minus_x[0] = 0;
    for (int c = 0; c < 3; ++c) y_minus_x[0] += direction_[c] * (y[c] - x[c]);
    return true;
  }
  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    for (int c = 0; c < 3; ++c) jacobian[c] = direction_[c];
    return true;
  }

 private:
  Eigen::Vector3d direction_;
};

}  // namespace burin
