// Similarities of the world: rigid motions with a scale. Two reconstructions of one scene differ by one.
#pragma once

#include <Eigen/Core>

#include "core/scene/camera.h"

namespace burin {

// x -> scale * rotation * x + translation; a rigid motion when scale is 1.
struct Similarity {
  double scale = 1;  // positive
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // world units of the target

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation;
  }
  // (a * b) * x = a * (b * x).
  Similarity operator*(const Similarity& first) const {
    return {scale * first.scale, rotation * first.rotation,
            scale * (rotation * first.translation) + translation};
  }
  Similarity Inverse() const {
    return {1 / scale, rotation.transpose(), -(rotation.transpose() * translation) / scale};
  }
  double AngleDeg() const;  // of the rotation, in [0, 180]
};

// The camera after the world was moved: Moved(c, m).Project(m * x) = c.Project(x).
Camera Moved(const Camera& camera, const Similarity& motion);

}  // namespace burin
