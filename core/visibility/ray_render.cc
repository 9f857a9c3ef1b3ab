#include "core/visibility/ray_render.h"

#include <embree3/rtcore.h>
#include <glog/logging.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kRowsPerItem = 4;
constexpr double kSameSurface = 1e-4;  // relative to the viewing distance

RTCRay MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double near,
               double far) {
  RTCRay ray;
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(near);
  ray.tfar = static_cast<float>(far);
  ray.time = 0;
  ray.mask = ~0U;
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

}  // namespace

struct MeshRays::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Handles() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

MeshRays::MeshRays(const TriangleMesh& mesh) : mesh_(mesh), handles_(std::make_unique<Handles>()) {
  handles_->device = rtcNewDevice(nullptr);
  CHECK(handles_->device != nullptr) << "Embree error " << rtcGetDeviceError(nullptr);
  handles_->scene = rtcNewScene(handles_->device);
  // Robust: no ray slips between two faces that share an edge.
  rtcSetSceneFlags(handles_->scene, RTC_SCENE_FLAG_ROBUST);
  if (!mesh.faces.empty()) {
    RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.faces.size()));
    CHECK(vertices != nullptr && indices != nullptr) << "Embree: out of memory";
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(vertex[axis]);
    }
    for (const Eigen::Vector3i& face : mesh.faces) {
      for (int c = 0; c < 3; ++c) *indices++ = static_cast<unsigned>(face[c]);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(handles_->scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(handles_->scene);
}

MeshRays::~MeshRays() = default;

bool MeshRays::Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         RayHit* hit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit query;
  query.ray = MakeRay(origin, direction, 0, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(handles_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->face = static_cast<int>(query.hit.primID);
  hit->barycentric = {1.0 - query.hit.u - query.hit.v, query.hit.u, query.hit.v};
  const Eigen::Vector3d normal = FaceAreaNormal(mesh_, hit->face);
  const double slope = normal.dot(direction);
  // Seen edge-on the plane says nothing: Embree's own distance is then the better one.
  const bool edge_on = std::abs(slope) <= 1e-9 * normal.norm() * direction.norm();
  hit->distance = edge_on ? query.ray.tfar
                          : normal.dot(mesh_.vertices[mesh_.faces[hit->face][0]] - origin) / slope;
  hit->point = origin + hit->distance * direction;
  return true;
}

bool MeshRays::Sees(const Camera& camera, const Eigen::Vector3d& point,
                    const Eigen::Vector3d& normal) const {
  if (camera.Depth(point) <= 0 || !camera.Contains(camera.Project(point))) return false;
  const Eigen::Vector3d to_camera = camera.Center() - point;
  if (normal.dot(to_camera) <= 0) return false;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = MakeRay(point, to_camera, kSameSurface, 1);
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar >= 0;
}

cv::Mat1f RenderView(const MeshRays& rays, const std::vector<Eigen::Vector3d>& vertex_normals,
                     const Camera& camera, const SurfaceShader& shader, double background,
                     int samples_per_axis) {
  cv::Mat1f image(camera.height, camera.width);
  const Eigen::Vector3d center = camera.Center();
  ParallelFor(camera.height, kRowsPerItem, [&](int begin, int end) {
    RayHit hit;
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < camera.width; ++col) {
        double sum = 0;
        for (int sample = 0; sample < samples_per_axis * samples_per_axis; ++sample) {
          const double x = col + (sample % samples_per_axis + 0.5) / samples_per_axis;
          const double y = row + (sample / samples_per_axis + 0.5) / samples_per_axis;
          if (!rays.Intersect(center, camera.Ray(x, y), &hit)) {
            sum += background;
            continue;
          }
          const Eigen::Vector3i& face = rays.mesh().faces[hit.face];
          const Eigen::Vector3d normal = hit.barycentric[0] * vertex_normals[face[0]] +
                                         hit.barycentric[1] * vertex_normals[face[1]] +
                                         hit.barycentric[2] * vertex_normals[face[2]];
          sum += shader(hit.point, normal.normalized());
        }
        image(row, col) = static_cast<float>(sum / (samples_per_axis * samples_per_axis));
      }
    }
  });
  return image;
}

cv::Mat1f RenderDepth(const MeshRays& rays, const Camera& camera) {
  cv::Mat1f depth(camera.height, camera.width);
  const Eigen::Vector3d center = camera.Center();
  ParallelFor(camera.height, kRowsPerItem, [&](int begin, int end) {
    RayHit hit;
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < camera.width; ++col) {
        // Rays have unit depth, so the distance along them is the depth.
        const bool seen = rays.Intersect(center, camera.Ray(col + 0.5, row + 0.5), &hit);
        depth(row, col) = seen ? static_cast<float>(hit.distance) : 0.0F;
      }
    }
  });
  return depth;
}

}  // namespace burin
