#include "core/scene/lens_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

constexpr int kMostSteps = 30;
constexpr double kConverged = 1e-12;  // normalised
constexpr double kSolved = 1e-9;

// Lens::brown as a function of the undistorted point, and its derivatives.
Eigen::Vector2d Photographed(const Lens& lens, const Eigen::Vector2d& point,
                             Eigen::Matrix2d* jacobian) {
  const auto& [k1, k2, p1, p2, k3] = lens.brown;
  const double u = point.x();
  const double v = point.y();
  const double r2 = u * u + v * v;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + 3 * r2 * k3);  // of radial by r2
  const double mixed = 2 * u * v * slope + 2 * p1 * u + 2 * p2 * v;
  *jacobian << radial + 2 * u * u * slope + 2 * p1 * v + 6 * p2 * u, mixed,  //
      mixed, radial + 2 * v * v * slope + 6 * p1 * v + 2 * p2 * u;
  return {u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u),
          v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v)};
}

// Newton's method from the photographed point on.
Eigen::Vector2d Solve(const Lens& lens, const Eigen::Vector2d& photographed) {
  Eigen::Vector2d point = photographed;
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d off = Photographed(lens, point, &jacobian) - photographed;
    const Eigen::Vector2d change = jacobian.inverse() * off;
    point -= change;
    if (!(change.norm() > kConverged)) break;
  }
  return point;
}

// r' (1 + k r'^2) = r for Lens::measured, by Newton's method from r.
Eigen::Vector2d Unmeasured(double k, const Eigen::Vector2d& point) {
  const double r = point.norm();
  if (r == 0) return point;
  double photographed = r;
  for (int step = 0; step < kMostSteps; ++step) {
    const double slope = 1 + 3 * k * photographed * photographed;
    if (slope <= 0) break;  // beyond where the lens folds back
    const double change = (photographed * (1 + k * photographed * photographed) - r) / slope;
    photographed -= change;
    if (!(std::abs(change) > kConverged)) break;
  }
  return point * (photographed / r);
}

}  // namespace

Eigen::Vector2d PhotographedAt(const Camera& camera, const Lens& lens,
                               const Eigen::Vector2d& undistorted) {
  if (lens.IsNone()) return undistorted;
  const Eigen::Array2d focal(camera.fx, camera.fy);
  const Eigen::Array2d center(camera.cx, camera.cy);
  const Eigen::Vector2d point = (undistorted.array() - center) / focal;
  Eigen::Matrix2d jacobian;
  const Eigen::Vector2d photographed =
      lens.measured != 0 ? Unmeasured(lens.measured, point) : Photographed(lens, point, &jacobian);
  return photographed.array() * focal + center;
}

PointUndistortion::PointUndistortion(const Camera& camera, const Lens& lens)
    : camera_(camera), lens_(lens), fold_radius_(FoldRadius(lens, 2 * CornerRadius(camera))) {}

std::optional<Eigen::Vector2d> PointUndistortion::operator()(
    const Eigen::Vector2d& photographed) const {
  if (!photographed.allFinite()) return std::nullopt;
  if (lens_.IsNone()) return photographed;
  const Eigen::Array2d focal(camera_.fx, camera_.fy);
  const Eigen::Array2d center(camera_.cx, camera_.cy);
  const Eigen::Vector2d seen = (photographed.array() - center) / focal;
  Eigen::Vector2d point;
  if (lens_.measured != 0) {
    // It grows up to there only.
    if (1 + 3 * lens_.measured * seen.squaredNorm() <= 0) return std::nullopt;
    point = seen * (1 + lens_.measured * seen.squaredNorm());
  } else {
    point = Solve(lens_, seen);
    Eigen::Matrix2d jacobian;
    if (!((Photographed(lens_, point, &jacobian) - seen).norm() <= kSolved)) return std::nullopt;
  }
  if (!(point.norm() <= fold_radius_)) return std::nullopt;
  return point.array() * focal + center;
}

}  // namespace burin
