#include "core/mesh/embree_mesh.h"

#include <glog/logging.h>

#include <limits>

#include "core/support/parallel.h"

namespace burin {

Eigen::Vector3d EmbreeMesh::Middle(const TriangleMesh& mesh) {
  return mesh.faces.empty() ? Eigen::Vector3d(0, 0, 0) : BoundingBox(mesh).center();
}

EmbreeMesh::EmbreeMesh(const TriangleMesh& mesh, const Eigen::Vector3d& origin, RTCSceneFlags flags)
    : origin_(origin) {
  const int vertex_count = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    CHECK(face.minCoeff() >= 0 && face.maxCoeff() < vertex_count) << "face index out of range";
  }
  device_ = rtcNewDevice(nullptr);
  CHECK(device_ != nullptr) << "Embree error " << rtcGetDeviceError(nullptr);
  scene_ = rtcNewScene(device_);
  // Robust: no ray slips through the edge between two facets.
  rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | flags));

  if (!mesh.faces.empty()) {
    Eigen::AlignedBox3d box = BoundingBox(mesh);
    box.extend(origin);
    rounding_ = box.diagonal().norm() * std::numeric_limits<float>::epsilon();

    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.faces.size()));
    CHECK(positions != nullptr && indices != nullptr) << "Embree is out of memory";
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Eigen::Vector3f local = Local(mesh.vertices[v]);
      for (int c = 0; c < 3; ++c) positions[3 * v + c] = local[c];
    }
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      for (int c = 0; c < 3; ++c) indices[3 * f + c] = static_cast<unsigned>(mesh.faces[f][c]);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }
  // Embree builds in the threads of whoever calls it: those of the run.
  ParallelFor(1, 1, [this](int, int) { rtcCommitScene(scene_); });
}

EmbreeMesh::~EmbreeMesh() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

}  // namespace burin
