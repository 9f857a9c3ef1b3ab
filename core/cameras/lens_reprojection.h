// Where a photograph shows a point, through its lens, as a residual for Ceres with derivatives by pose, intrinsics and point.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "core/cameras/intrinsics.h"
#include "core/scene/undistort.h"

namespace burin {

// The photographed place of the normalised point (u, v) through k1, k2, p1, p2, k3: `Lens::brown`.
template <typename T>
Eigen::Matrix<T, 2, 1> ThroughBrown(const std::array<T, 5>& brown, const T& u, const T& v) {
  const auto& [k1, k2, p1, p2, k3] = brown;
  const T r2 = u * u + v * v;
  const T radial = T(1) + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {u * radial + T(2) * p1 * u * v + p2 * (r2 + T(2) * u * u),
          v * radial + T(2) * p2 * u * v + p1 * (r2 + T(2) * v * v)};
}

inline double ValueOf(double number) { return number; }
template <typename Jet>
double ValueOf(const Jet& jet) {
  return jet.a;
}

// The same through Lens::measured = k: t (u, v), where t + k r^2 t^3 = 1. Newton's method in doubles, and one step of
// it with derivatives, which makes these exact. False where the lens folds back.
template <typename T>
bool ThroughMeasured(const T& k, const T& u, const T& v, Eigen::Matrix<T, 2, 1>* photographed) {
  constexpr int kSteps = 30;
  const T q = k * (u * u + v * v);
  const double fixed = ValueOf(q);
  double t = 1;
  for (int step = 0; step < kSteps; ++step) {
    const double slope = 1 + 3 * fixed * t * t;
    if (!(slope > 0)) return false;
    t -= (t + fixed * t * t * t - 1) / slope;
  }
  const double slope = 1 + 3 * fixed * t * t;
  if (!(slope > 0)) return false;
  const T scale = T(t) - (T(t) + q * T(t * t * t) - T(1)) / T(slope);
  *photographed << scale * u, scale * v;
  return true;
}

// (x(X) - x) / s: x where the photograph shows the point, s pixels of it to one of the image searched.
struct LensReprojection {
  const SharedIntrinsics& shared;
  Eigen::Vector2d photographed;
  double scale;

  // `pose`: CameraPose. `q`: IntrinsicNumbers.
  template <typename T>
  bool operator()(const T* pose, const T* q, const T* point, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> center(pose + 4);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> world(point);
    const Eigen::Matrix<T, 3, 1> seen = rotation * (world - center);
    const T u = seen.x() / seen.z();
    const T v = seen.y() / seen.z();
    Eigen::Matrix<T, 2, 1> at;
    if (shared.lens.measured != 0) {
      const T k = shared.lens.measured + q[kMeasured] * shared.unit[kMeasured];
      if (!ThroughMeasured(k, u, v, &at)) return false;
    } else {
      std::array<T, 5> brown;
      for (int k = 0; k < 5; ++k) {
        brown[k] = shared.lens.brown[k] + q[kBrown + k] * shared.unit[kBrown + k];
      }
      at = ThroughBrown(brown, u, v);
    }
    const Camera& camera = shared.camera;
    const T larger = T(1) + q[kFocal] * shared.unit[kFocal];
    const T higher = T(1) + q[kRatio] * shared.unit[kRatio];
    const T cx = camera.cx + q[kCenter] * shared.unit[kCenter];
    const T cy = camera.cy + q[kCenter + 1] * shared.unit[kCenter + 1];
    residuals[0] = (camera.fx * larger * at.x() + cx - photographed.x()) / scale;
    residuals[1] = (camera.fy * larger * higher * at.y() + cy - photographed.y()) / scale;
    return true;
  }
};

}  // namespace burin
