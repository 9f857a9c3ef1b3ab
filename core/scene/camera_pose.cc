#include "core/scene/camera_pose.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace burin {

static_assert(sizeof(CameraPose) == CameraPose::kSize * sizeof(double), "a block of doubles");

bool CameraPose::operator==(const CameraPose& other) const {
  return std::equal(data(), data() + kSize, other.data());
}

CameraPose PoseOf(const Camera& camera) {
  CameraPose pose;
  Eigen::Map<Eigen::Quaterniond>(pose.rotation) = Eigen::Quaterniond(camera.rotation).normalized();
  Eigen::Map<Eigen::Vector3d>(pose.center) = camera.Center();
  return pose;
}

void SetPose(const CameraPose& pose, Camera* camera) {
  camera->rotation =
      Eigen::Map<const Eigen::Quaterniond>(pose.rotation).normalized().toRotationMatrix();
  camera->translation = -camera->rotation * Eigen::Map<const Eigen::Vector3d>(pose.center);
}

Eigen::Matrix<double, 6, Eigen::Dynamic> MotionsOf(const CameraPose& pose, const double* plus,
                                                   int columns) {
  const Eigen::Map<const Eigen::Matrix<double, CameraPose::kSize, Eigen::Dynamic, Eigen::RowMajor>>
      directions(plus, CameraPose::kSize, columns);
  const Eigen::Quaterniond back = Eigen::Map<const Eigen::Quaterniond>(pose.rotation).inverse();
  Eigen::Matrix<double, 6, Eigen::Dynamic> motions(6, columns);
  for (int u = 0; u < columns; ++u) {
    Eigen::Quaterniond direction;
    direction.coeffs() = directions.col(u).head<4>();
    motions.col(u).head<3>() = 2 * (direction * back).vec();
    motions.col(u).tail<3>() = directions.col(u).tail<3>();
  }
  return motions;
}

}  // namespace burin
