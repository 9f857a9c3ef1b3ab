// Where a camera is, as the seven numbers that a solver moves: one parameter block of Ceres.
#pragma once

#include <Eigen/Core>

#include "core/scene/camera.h"

namespace burin {

// As doubles one after the other: `rotation`, then `center`.
struct CameraPose {
  double rotation[4] = {0, 0, 0,
                        1};  // unit quaternion x, y, z, w of cam_from_world's R, as Eigen stores it
  double center[3] = {0, 0, 0};  // c, world units

  double* data() { return rotation; }
  const double* data() const { return rotation; }
  bool operator==(const CameraPose& other) const;

  static constexpr int kSize = 7;
};

CameraPose PoseOf(const Camera& camera);
// Leaves the intrinsics. A rotation that is no unit quaternion is taken for its multiple that is one.
void SetPose(const CameraPose& pose, Camera* camera);

// Derivatives by a pose are by its motion (w, dc): R <- Exp(w) R, c <- c + dc, the rotation vector w in the camera's
// frame. These are the motions, 6 x columns, that the directions `plus` of the seven numbers stand for (7 x columns,
// row-major; core/solve/energy_blocks.h: TangentDirections).
Eigen::Matrix<double, 6, Eigen::Dynamic> MotionsOf(const CameraPose& pose, const double* plus,
                                                   int columns);

}  // namespace burin
