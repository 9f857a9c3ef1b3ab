#include "core/scene/similarity.h"

#include <cmath>

namespace burin {

double Similarity::AngleDeg() const {
  // atan2 of (2 sin, 2 cos): exact for small angles, where acos of the trace loses half the digits.
  const Eigen::Vector3d twice_sine(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                                   rotation(1, 0) - rotation(0, 1));
  return std::atan2(twice_sine.norm(), rotation.trace() - 1) * 180 / M_PI;
}

Camera Moved(const Camera& camera, const Similarity& motion) {
  // R X + t at X = Q^T (X' - T) / s, multiplied by s (a projective camera ignores it).
  Camera moved = camera;
  moved.rotation = camera.rotation * motion.rotation.transpose();
  moved.translation = motion.scale * camera.translation - moved.rotation * motion.translation;
  moved.near_depth = motion.scale * camera.near_depth;
  return moved;
}

}  // namespace burin
