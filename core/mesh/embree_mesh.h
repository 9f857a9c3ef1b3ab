// A triangle mesh inside an Embree scene, and the rays sent into it: what ray casting and
// closest-point queries share.
#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <limits>

#include "core/mesh/mesh.h"

namespace burin {

// Embree computes in float. Positions are stored relative to an origin at the mesh, so that
// georeferenced meshes (coordinates in the millions) keep their detail; rays and queries start
// at Local() points, and callers redo in double whatever they return. Immutable once built:
// any number of threads may query it. CHECKs that face indices are in range.
class EmbreeMesh {
 public:
  // `flags` are added to RTC_SCENE_FLAG_ROBUST.
  explicit EmbreeMesh(const TriangleMesh& mesh, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE)
      : EmbreeMesh(mesh, Middle(mesh), flags) {}
  EmbreeMesh(const TriangleMesh& mesh, const Eigen::Vector3d& origin, RTCSceneFlags flags);
  ~EmbreeMesh();
  EmbreeMesh(const EmbreeMesh&) = delete;
  EmbreeMesh& operator=(const EmbreeMesh&) = delete;

  RTCScene scene() const { return scene_; }
  Eigen::Vector3f Local(const Eigen::Vector3d& point) const {
    return (point - origin_).cast<float>();
  }
  // Bound on how far a stored vertex lies from the true one, world units.
  double rounding() const { return rounding_; }

 private:
  static Eigen::Vector3d Middle(const TriangleMesh& mesh);  // of its bounding box

  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  Eigen::Vector3d origin_;
  double rounding_ = 0;
};

// The points from + t * direction with near <= t <= far, `from` as EmbreeMesh::Local gives it.
struct EmbreeRay {
  Eigen::Vector3f from;
  Eigen::Vector3f direction;
  float near = 0;
  float far = std::numeric_limits<float>::infinity();
  unsigned int id = 0;

  // Makes it ray `lane` of an RTCRay8, an RTCRay16, ...; or an RTCRay, which has lane 0.
  template <typename Rays>
  void Put(int lane, Rays* rays) const {
    auto* packet = reinterpret_cast<RTCRayN*>(rays);
    constexpr unsigned int kLanes = sizeof(Rays) / sizeof(RTCRay);
    RTCRayN_org_x(packet, kLanes, lane) = from.x();
    RTCRayN_org_y(packet, kLanes, lane) = from.y();
    RTCRayN_org_z(packet, kLanes, lane) = from.z();
    RTCRayN_dir_x(packet, kLanes, lane) = direction.x();
    RTCRayN_dir_y(packet, kLanes, lane) = direction.y();
    RTCRayN_dir_z(packet, kLanes, lane) = direction.z();
    RTCRayN_tnear(packet, kLanes, lane) = near;
    RTCRayN_tfar(packet, kLanes, lane) = far;
    RTCRayN_time(packet, kLanes, lane) = 0;
    RTCRayN_mask(packet, kLanes, lane) = ~0U;
    RTCRayN_id(packet, kLanes, lane) = id;
    RTCRayN_flags(packet, kLanes, lane) = 0;
  }
};

}  // namespace burin
