// A calibrated pinhole camera: the only camera the rest of burin knows.
//
// Conventions, said once here and valid at every interface:
//  - cam_from_world maps world points to the camera frame: X_cam = R * X_world + t;
//    x right, y down, z forward (COLMAP's and OpenCV's axes).
//  - Image coordinates are in pixels with the centre of the top-left pixel at (0.5, 0.5); the image
//    covers [0, width] x [0, height]. Array element (row, col) is the sample at (col+0.5, row+0.5).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace burin {

struct Camera {
  int width = 0;                                           // pixels
  int height = 0;                                          // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;                   // pixels
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // R of cam_from_world
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   // t of cam_from_world, world units
  // World units; surface at a smaller depth is not seen, and hides nothing.
  double near_depth = 0;

  // Camera centre in the world, c = -R^T t.
  Eigen::Vector3d Center() const { return -rotation.transpose() * translation; }

  // Direction in the world frame of the ray through image point (x, y), scaled to unit depth: the
  // point at depth z is Center() + z * Ray(x, y).
  Eigen::Vector3d Ray(double x, double y) const {
    return rotation.transpose() * Eigen::Vector3d((x - cx) / fx, (y - cy) / fy, 1.0);
  }

  // Depth (camera z) of a world point, world units; positive in front of the camera.
  double Depth(const Eigen::Vector3d& point) const {
    return rotation.row(2).dot(point) + translation.z();
  }

  // Image point of a world point. Meaningful only where Depth(point) > 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d in_camera = rotation * point + translation;
    return {fx * in_camera.x() / in_camera.z() + cx, fy * in_camera.y() / in_camera.z() + cy};
  }

  // Derivative of Project by the point, of which `seen` = R point + t; pixels per world unit.
  Eigen::Matrix<double, 2, 3> ProjectByPoint(const Eigen::Vector3d& seen) const {
    Eigen::Matrix<double, 2, 3> by_seen;
    by_seen << fx, 0, -fx * seen.x() / seen.z(), 0, fy, -fy * seen.y() / seen.z();
    return by_seen / seen.z() * rotation;
  }

  bool Contains(const Eigen::Vector2d& image_point) const {
    return image_point.x() >= 0 && image_point.y() >= 0 && image_point.x() <= width &&
           image_point.y() <= height;
  }

  // Width in world units that one pixel covers at a point (fronto-parallel): depth / focal length,
  // with the geometric mean of fx and fy.
  double Footprint(const Eigen::Vector3d& point) const { return Depth(point) / std::sqrt(fx * fy); }

  bool HasIntrinsicsOf(const Camera& other) const {
    return fx == other.fx && fy == other.fy && cx == other.cx && cy == other.cy;
  }

  // The 3x4 matrix P = K [R | t].
  Eigen::Matrix<double, 3, 4> ProjectionMatrix() const;

  // The same camera for an image resampled to new_width x new_height.
  Camera Resized(int new_width, int new_height) const;

  // The same camera after the world was mapped by X -> scale * (X - origin).
  Camera InScaledWorld(const Eigen::Vector3d& origin, double scale) const;
};

}  // namespace burin
