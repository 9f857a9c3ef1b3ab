#include "core/visibility/mesh_rays.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/mesh/embree_mesh.h"

namespace burin {
namespace {

constexpr float kSameSurface = 1e-4F;  // relative to the viewing distance
constexpr double kEdgeOn = 1e-3;       // sine of the angle between ray and face

}  // namespace

MeshRays::MeshRays(const TriangleMesh& mesh)
    : mesh_(mesh), embree_(std::make_unique<EmbreeMesh>(mesh)) {}

MeshRays::MeshRays(const TriangleMesh& mesh, const Eigen::Vector3d& origin)
    : mesh_(mesh), embree_(std::make_unique<EmbreeMesh>(mesh, origin, RTC_SCENE_FLAG_NONE)) {}

MeshRays::~MeshRays() = default;

bool MeshRays::Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         RayHit* hit, double far) const {
  EmbreeRay ray;
  ray.from = embree_->Local(origin);
  ray.direction = direction.cast<float>();
  ray.far = static_cast<float>(far);
  RTCRayHit query;
  ray.Put(0, &query.ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(embree_->scene(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->face = static_cast<int>(query.hit.primID);
  hit->barycentric = {1.0 - query.hit.u - query.hit.v, query.hit.u, query.hit.v};
  const Eigen::Vector3d normal = FaceAreaNormal(mesh_, hit->face);
  const double slope = normal.dot(direction);
  // Nearly edge-on, the plane says less about the distance than Embree does.
  const bool edge_on = std::abs(slope) <= kEdgeOn * normal.norm() * direction.norm();
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
  EmbreeRay ray;
  ray.from = embree_->Local(point);
  ray.direction = to_camera.cast<float>();
  ray.near = kSameSurface;
  ray.far = 1;
  RTCRay query;
  ray.Put(0, &query);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(embree_->scene(), &context, &query);
  return query.tfar >= 0;
}

}  // namespace burin
