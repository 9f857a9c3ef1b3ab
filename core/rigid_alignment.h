// Rigid motions, and the one that best lays a set of surface points onto another surface: ground
// truth and photographs are rarely registered to the last millimetre.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace burin {

// x -> rotation * x + translation.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // world units

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
  // (a * b) * x = a * (b * x).
  RigidMotion operator*(const RigidMotion& first) const {
    return {rotation * first.rotation, rotation * first.translation + translation};
  }
  RigidMotion Inverse() const {
    return {rotation.transpose(), -(rotation.transpose() * translation)};
  }
  double AngleDeg() const;  // in [0, 180]
};

// A point's counterpart on the other surface and the unit normal of the plane its distance is
// measured to. False when there is none close enough; a normal of zero length leaves the pair out.
using PlaneOf = std::function<bool(int index, const Eigen::Vector3d& moved_point,
                                   Eigen::Vector3d* counterpart, Eigen::Vector3d* normal)>;

struct AlignmentOptions {
  double keep_fraction = 0.7;  // share of the pairs, those with the smallest residuals, that count
  int max_iterations = 100;
  double min_step = 1e-9;  // stop when no point moves further than this share of the points' extent
};

struct Alignment {
  RigidMotion motion;      // maps the points given onto the other surface
  int iterations = 0;      // done
  bool converged = false;  // by min_step; the motion is usable either way
  int pair_count = 0;      // pairs kept in the last iteration
  double rmse = 0;         // of the kept pairs' plane distances before the last step, world units
};

// Trimmed iterative closest point with the point-to-plane error: each iteration moves the points,
// asks plane_of (on several threads) for their counterparts, keeps the keep_fraction with the
// smallest |n.(x - q)| and minimises the sum of their squares over small motions (Chen and Medioni
// 1992; trimming as in Chetverikov et al. 2002). Directions of motion that the pairs do not
// constrain (sliding along a plane, turning a sphere) are left alone. Starts at the identity.
// False with *error when fewer than six pairs are found.
bool AlignPointsToPlanes(const std::vector<Eigen::Vector3d>& points, const PlaneOf& plane_of,
                         const AlignmentOptions& options, Alignment* alignment, std::string* error);

}  // namespace burin
