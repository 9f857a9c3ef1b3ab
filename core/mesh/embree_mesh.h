// A triangle mesh inside an Embree scene: what ray casting and closest-point queries share.
#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>

#include "core/mesh/mesh.h"

namespace burin {

// Embree computes in float. Positions are stored relative to the centre of the bounding box, so
// that georeferenced meshes (coordinates in the millions) keep their detail; callers subtract
// origin() from rays and queries, and redo in double whatever they return. Immutable once built:
// any number of threads may query it. CHECKs that face indices are in range.
class EmbreeMesh {
 public:
  // `flags` are added to RTC_SCENE_FLAG_ROBUST.
  explicit EmbreeMesh(const TriangleMesh& mesh, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE);
  ~EmbreeMesh();
  EmbreeMesh(const EmbreeMesh&) = delete;
  EmbreeMesh& operator=(const EmbreeMesh&) = delete;

  RTCScene scene() const { return scene_; }
  const Eigen::Vector3d& origin() const { return origin_; }
  // Bound on how far a stored vertex lies from the true one, world units.
  double rounding() const { return rounding_; }

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double rounding_ = 0;
};

}  // namespace burin
