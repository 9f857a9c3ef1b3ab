// How well shaped a triangle is.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace burin {

// 4 sqrt(3) area / sum of squared edge lengths: 1 for an equilateral triangle, 0 for one without area.
inline double FacetQuality(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c) {
  const Eigen::Vector3d u = b - a;
  const Eigen::Vector3d v = c - a;
  const double squares = u.squaredNorm() + v.squaredNorm() + (u - v).squaredNorm();
  return squares > 0 ? 2 * std::sqrt(3.0) * u.cross(v).norm() / squares : 0.0;
}

}  // namespace burin
