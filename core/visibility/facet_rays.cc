#include "core/visibility/facet_rays.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace burin {
namespace {

constexpr int kPacket = 8;
// Occlusion rays start this share of their length away from their surface point, far below a
// hundredth of a pixel: it spares most calls of the filter, which alone decides what the ray's
// start may touch.
constexpr float kRayStart = 1e-6F;

// Carried by the occlusion rays to one center to the filter below.
struct OcclusionContext {
  RTCIntersectContext context;         // must come first
  const Eigen::Vector3i* faces;        // the mesh's
  const std::vector<uint8_t>* facing;  // the center
};

// Rejects the hits that are no obstacles. A ray's id is the facet it starts on.
void RejectOwnNeighbourhood(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const OcclusionContext*>(args->context);
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const unsigned int start = RTCRayN_id(args->ray, args->N, i);
    const unsigned int hit = RTCHitN_primID(args->hit, args->N, i);
    if (hit == start ||
        ((*context->facing)[hit] != 0 && ShareVertex(context->faces[hit], context->faces[start]))) {
      args->valid[i] = 0;
    }
  }
}

}  // namespace

FacetRays::FacetRays(const TriangleMesh& mesh)
    : mesh_(mesh), embree_(mesh, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) {}

void FacetRays::CastToCamera(const Camera& camera, const std::vector<uint8_t>& facing,
                             const Eigen::Vector3d* points, const int* facets, int count,
                             uint8_t* visible) const {
  const Eigen::Vector3d center = camera.Center();
  OcclusionContext occlusion;
  rtcInitIntersectContext(&occlusion.context);
  occlusion.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  occlusion.context.filter = RejectOwnNeighbourhood;
  occlusion.faces = mesh_.faces.data();
  occlusion.facing = &facing;
  for (int base = 0; base < count; base += kPacket) {
    alignas(32) int valid[kPacket];
    RTCRay8 rays;
    for (int lane = 0; lane < kPacket; ++lane) {
      const int k = base + lane;
      valid[lane] = k < count && facing[facets[std::min(k, count - 1)]] != 0 ? -1 : 0;
      if (valid[lane] == 0) continue;
      EmbreeRay ray;
      ray.far = 1;
      if (camera.near_depth > 0) {
        const double depth = camera.Depth(points[k]);
        ray.far = static_cast<float>(1 - camera.near_depth / depth);
        if (!(depth > camera.near_depth)) valid[lane] = 0;
      }
      ray.from = embree_.Local(points[k]);
      ray.direction = (center - points[k]).cast<float>();
      ray.near = kRayStart;
      ray.id = static_cast<unsigned int>(facets[k]);
      ray.Put(lane, &rays);
    }
    rtcOccluded8(valid, embree_.scene(), &occlusion.context, &rays);
    for (int lane = 0; lane < kPacket && base + lane < count; ++lane) {
      visible[base + lane] = valid[lane] != 0 && rays.tfar[lane] >= 0 ? 1 : 0;
    }
  }
}

}  // namespace burin
