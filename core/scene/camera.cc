#include "core/scene/camera.h"

namespace burin {

Eigen::Matrix<double, 3, 4> Camera::ProjectionMatrix() const {
  Eigen::Matrix3d intrinsics;
  intrinsics << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  Eigen::Matrix<double, 3, 4> cam_from_world;
  cam_from_world << rotation, translation;
  return intrinsics * cam_from_world;
}

Camera Camera::Resized(int new_width, int new_height) const {
  // With pixel centres at half-integers the image rectangle [0,w]x[0,h] scales without an offset.
  Camera resized = *this;
  const double scale_x = static_cast<double>(new_width) / width;
  const double scale_y = static_cast<double>(new_height) / height;
  resized.width = new_width;
  resized.height = new_height;
  resized.fx *= scale_x;
  resized.cx *= scale_x;
  resized.fy *= scale_y;
  resized.cy *= scale_y;
  return resized;
}

Camera Camera::InScaledWorld(const Eigen::Vector3d& origin, double scale) const {
  // R (X' / scale + origin) + t, multiplied by scale (a projective camera ignores it).
  Camera moved = *this;
  moved.translation = scale * (rotation * origin + translation);
  moved.near_depth = scale * near_depth;
  return moved;
}

}  // namespace burin
