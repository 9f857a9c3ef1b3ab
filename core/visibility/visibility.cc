#include "core/visibility/visibility.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/mesh/embree_mesh.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"

namespace burin {
namespace {

constexpr int kPacket = 8;
constexpr int kPointGrain = 4096;
constexpr int kRowGrain = 16;
constexpr int kFacetGrain = 512;
// Occlusion rays start this share of their length away from their surface point, far below a
// hundredth of a pixel: it spares most calls of the filter, which alone decides what the ray's
// start may touch.
constexpr float kRayStart = 1e-6F;

// Carried by the occlusion rays of one target to the filter below.
struct OcclusionContext {
  RTCIntersectContext context;               // must come first
  const Eigen::Vector3i* faces;              // the mesh's
  const std::vector<uint8_t>* faces_target;  // per facet: its front side sees the target
};

// Without branches: whether two facets touch is as good as random.
bool ShareVertex(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) shared |= static_cast<int>(a[i] == b[j]);
  }
  return shared != 0;
}

// Rejects the hits that are no obstacles (see the header). A ray's id is the facet it starts on.
void RejectOwnNeighbourhood(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const OcclusionContext*>(args->context);
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const unsigned int start = RTCRayN_id(args->ray, args->N, i);
    const unsigned int hit = RTCHitN_primID(args->hit, args->N, i);
    if (hit == start || ((*context->faces_target)[hit] != 0 &&
                         ShareVertex(context->faces[hit], context->faces[start]))) {
      args->valid[i] = 0;
    }
  }
}

}  // namespace

struct RayCaster::Impl {
  explicit Impl(const TriangleMesh& given)
      : mesh(given), embree(given, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) {}

  TriangleMesh mesh;
  EmbreeMesh embree;

  std::vector<uint8_t> FacesTarget(const Eigen::Vector3d& center) const {
    std::vector<uint8_t> result(mesh.faces.size());
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      result[f] =
          FaceAreaNormal(mesh, static_cast<int>(f)).dot(center - mesh.vertices[mesh.faces[f][0]]) >
          0;
    }
    return result;
  }

  // PointsVisible for a slice, with the facing table at hand.
  void CastOcclusion(const Eigen::Vector3d& center, const std::vector<uint8_t>& faces_target,
                     const Eigen::Vector3d* points, const int* facets, int count,
                     uint8_t* visible) const;
  void BuildPixelLists(const Camera& camera, const cv::Mat1i& facet_map, ViewDomain* domain) const;
  // `facing` and `facet_maps` hold FacesTarget of every camera that appears in a pair, and which of
  // those facets each of its pixels sees.
  void CastPairs(const std::vector<Camera>& cameras, int view,
                 const std::vector<std::vector<uint8_t>>& facing,
                 const std::vector<cv::Mat1i>& facet_maps, const std::vector<cv::Mat>& masks,
                 double border_px, const ViewDomain& domain, ViewPartners* partners) const;
  // The four pixels around image point (x, y) all see `facet` or facets that share a vertex with it:
  // then nothing as large as a pixel is in front of it there.
  bool SeenAround(const cv::Mat1i& facet_map, double x, double y, int facet) const;
};

void RayCaster::Impl::CastOcclusion(const Eigen::Vector3d& center,
                                    const std::vector<uint8_t>& faces_target,
                                    const Eigen::Vector3d* points, const int* facets, int count,
                                    uint8_t* visible) const {
  OcclusionContext occlusion;
  rtcInitIntersectContext(&occlusion.context);
  occlusion.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  occlusion.context.filter = RejectOwnNeighbourhood;
  occlusion.faces = mesh.faces.data();
  occlusion.faces_target = &faces_target;
  for (int base = 0; base < count; base += kPacket) {
    alignas(32) int valid[kPacket];
    RTCRay8 rays;
    for (int lane = 0; lane < kPacket; ++lane) {
      const int k = base + lane;
      valid[lane] = k < count && faces_target[facets[std::min(k, count - 1)]] != 0 ? -1 : 0;
      if (valid[lane] == 0) continue;
      const Eigen::Vector3f from = (points[k] - embree.origin()).cast<float>();
      const Eigen::Vector3f step = (center - points[k]).cast<float>();
      rays.org_x[lane] = from.x();
      rays.org_y[lane] = from.y();
      rays.org_z[lane] = from.z();
      rays.dir_x[lane] = step.x();
      rays.dir_y[lane] = step.y();
      rays.dir_z[lane] = step.z();
      rays.tnear[lane] = kRayStart;
      rays.tfar[lane] = 1.0F;
      rays.time[lane] = 0.0F;
      rays.mask[lane] = ~0U;
      rays.id[lane] = static_cast<unsigned int>(facets[k]);
      rays.flags[lane] = 0;
    }
    rtcOccluded8(valid, embree.scene(), &occlusion.context, &rays);
    for (int lane = 0; lane < kPacket && base + lane < count; ++lane) {
      visible[base + lane] = valid[lane] != 0 && rays.tfar[lane] >= 0 ? 1 : 0;
    }
  }
}

void RayCaster::Impl::BuildPixelLists(const Camera& camera, const cv::Mat1i& facet_map,
                                      ViewDomain* domain) const {
  const int width = camera.width;
  const int height = camera.height;
  std::vector<int> slot(mesh.faces.size(), -1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (facet_map(y, x) >= 0) slot[facet_map(y, x)] = 0;
    }
  }
  for (size_t f = 0; f < slot.size(); ++f) {
    if (slot[f] < 0) continue;
    slot[f] = static_cast<int>(domain->facet.size());
    domain->facet.push_back(static_cast<int>(f));
  }
  std::vector<Eigen::Matrix3d> pencils(domain->facet.size());
  const ViewRays rays(camera);
  for (size_t k = 0; k < pencils.size(); ++k) {
    pencils[k] = MakeFacetPencil(mesh.vertices, mesh.faces[domain->facet[k]], rays).coefficients;
  }
  // Counting sort of the pixels by facet corner keeps them in ascending order within each.
  std::vector<uint32_t> corner_of(static_cast<size_t>(width) * height,
                                  std::numeric_limits<uint32_t>::max());
  domain->start.assign(3 * domain->facet.size() + 1, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (facet_map(y, x) < 0) continue;
      const int k = slot[facet_map(y, x)];
      const Eigen::Vector3d u = pencils[k] * Eigen::Vector3d(x + 0.5, y + 0.5, 1);
      const int corner = u[0] >= u[1] ? (u[0] >= u[2] ? 0 : 2) : (u[1] >= u[2] ? 1 : 2);
      corner_of[static_cast<size_t>(y) * width + x] = static_cast<uint32_t>(3 * k + corner);
      ++domain->start[3 * k + corner + 1];
    }
  }
  for (size_t c = 1; c < domain->start.size(); ++c) domain->start[c] += domain->start[c - 1];
  domain->pixel.resize(domain->start.back());
  std::vector<uint32_t> next(domain->start.begin(), domain->start.end() - 1);
  for (size_t p = 0; p < corner_of.size(); ++p) {
    if (corner_of[p] == std::numeric_limits<uint32_t>::max()) continue;
    domain->pixel[next[corner_of[p]]++] = static_cast<uint32_t>(p);
  }
}

bool RayCaster::Impl::SeenAround(const cv::Mat1i& facet_map, double x, double y, int facet) const {
  if (x < 0.5 || y < 0.5) return false;
  const int column = static_cast<int>(x - 0.5);
  const int row = static_cast<int>(y - 0.5);
  if (column + 1 >= facet_map.cols || row + 1 >= facet_map.rows) return false;
  const int* above = facet_map[row] + column;
  const int* below = facet_map[row + 1] + column;
  int neighbor = facet;  // the last one looked up
  for (const int seen : {above[0], above[1], below[0], below[1]}) {
    if (seen == facet || seen == neighbor) continue;
    if (seen < 0 || !ShareVertex(mesh.faces[seen], mesh.faces[facet])) return false;
    neighbor = seen;
  }
  return true;
}

void RayCaster::Impl::CastPairs(const std::vector<Camera>& cameras, int view,
                                const std::vector<std::vector<uint8_t>>& facing,
                                const std::vector<cv::Mat1i>& facet_maps,
                                const std::vector<cv::Mat>& masks, double border_px,
                                const ViewDomain& domain, ViewPartners* partners) const {
  const cv::Mat1i& facet_map = facet_maps[view];
  const cv::Mat mask = masks.empty() ? cv::Mat() : masks[view];
  const Camera& reference = cameras[view];
  const int width = reference.width;
  const Eigen::Vector3d center_i = reference.Center();
  // Inverse depth along the ray of every pixel, affine in the pixel for each facet; 0 = no facet.
  cv::Mat1d inverse_depth(reference.height, width, 0.0);
  const ViewRays rays(reference);
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Eigen::RowVector3d row =
          MakeFacetPencil(mesh.vertices, mesh.faces[domain.facet[k]], rays).InverseDepth();
      for (uint32_t n = domain.start[3 * k]; n < domain.start[3 * k + 3]; ++n) {
        const int x = static_cast<int>(domain.pixel[n]) % width;
        const int y = static_cast<int>(domain.pixel[n]) / width;
        inverse_depth(y, x) = row[0] * (x + 0.5) + row[1] * (y + 0.5) + row[2];
      }
    }
  });
  partners->second_visible.assign(
      (partners->seconds.size() + 7) / 8,
      std::vector<uint8_t>(static_cast<size_t>(width) * reference.height, 0));
  for (size_t b = 0; b < partners->seconds.size(); ++b) {
    const Camera& second = cameras[partners->seconds[b]];
    const Eigen::Vector3d center_j = second.Center();
    const std::vector<uint8_t>& faces_second = facing[partners->seconds[b]];
    const cv::Mat1i& second_map = facet_maps[partners->seconds[b]];
    const cv::Mat second_mask = masks.empty() ? cv::Mat() : masks[partners->seconds[b]];
    const Eigen::Matrix<double, 3, 4> projection = second.ProjectionMatrix();
    const Eigen::Vector3d step_q = projection.leftCols<3>() * rays.ray_from_pixel.col(0);
    const Eigen::Vector3d epipole = projection.leftCols<3>() * center_i + projection.col(3);
    std::vector<uint8_t>& plane = partners->second_visible[b / 8];
    const auto bit = static_cast<uint8_t>(1U << (b % 8));
    std::vector<int64_t> row_count(reference.height, 0);
    ParallelFor(reference.height, kRowGrain, [&](int begin, int end) {
      std::vector<Eigen::Vector3d> points;
      std::vector<int> facets;
      std::vector<int> columns;
      std::vector<uint8_t> visible;
      for (int y = begin; y < end; ++y) {
        points.clear();
        facets.clear();
        columns.clear();
        const int* facet_row = facet_map[y];
        const double* inverse_row = inverse_depth[y];
        const Eigen::Vector3d row_ray = rays.ray_from_pixel * Eigen::Vector3d(0.5, y + 0.5, 1);
        const Eigen::Vector3d row_q = projection.leftCols<3>() * row_ray;
        for (int x = 0; x < width; ++x) {
          const int facet = facet_row[x];
          if (facet < 0 || faces_second[facet] == 0) continue;
          if (!mask.empty() && mask.at<uint8_t>(y, x) == 0) continue;
          // Homogeneous image point in j, times the inverse depth.
          const Eigen::Vector3d q =
              row_q + static_cast<double>(x) * step_q + inverse_row[x] * epipole;
          const double margin = border_px * q.z();
          if (q.z() <= 0 || q.x() < margin || q.y() < margin ||
              q.x() > second.width * q.z() - margin || q.y() > second.height * q.z() - margin) {
            continue;
          }
          if (!second_mask.empty()) {
            const int column = std::clamp(static_cast<int>(q.x() / q.z()), 0, second.width - 1);
            const int row = std::clamp(static_cast<int>(q.y() / q.z()), 0, second.height - 1);
            if (second_mask.at<uint8_t>(row, column) == 0) continue;
          }
          if (SeenAround(second_map, q.x() / q.z(), q.y() / q.z(), facet)) {
            plane[static_cast<size_t>(y) * width + x] |= bit;
            ++row_count[y];
            continue;
          }
          const Eigen::Vector3d point =
              center_i +
              (row_ray + static_cast<double>(x) * rays.ray_from_pixel.col(0)) / inverse_row[x];
          points.push_back(point);
          facets.push_back(facet);
          columns.push_back(x);
        }
        visible.resize(points.size());
        CastOcclusion(center_j, faces_second, points.data(), facets.data(),
                      static_cast<int>(points.size()), visible.data());
        const size_t first = static_cast<size_t>(y) * width;
        for (size_t k = 0; k < columns.size(); ++k) {
          if (visible[k] == 0) continue;
          plane[first + columns[k]] |= bit;
          ++row_count[y];
        }
      }
    });
    int64_t total = 0;
    for (int64_t count : row_count) total += count;
    partners->pair_pixels.push_back(total);
  }
}

RayCaster::RayCaster(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}

RayCaster::~RayCaster() = default;

cv::Mat1i RayCaster::FacetMap(const Camera& camera) const {
  cv::Mat1i facets(camera.height, camera.width, -1);
  const Eigen::Vector3f center = (camera.Center() - impl_->embree.origin()).cast<float>();
  const Eigen::Matrix3d ray_from_pixel = ViewRays(camera).ray_from_pixel;
  ParallelFor(camera.height, kRowGrain, [&](int begin, int end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (int y = begin; y < end; ++y) {
      const Eigen::Vector3d row_ray = ray_from_pixel * Eigen::Vector3d(0.5, y + 0.5, 1);
      for (int base = 0; base < camera.width; base += kPacket) {
        alignas(32) int valid[kPacket];
        RTCRayHit8 rays;
        for (int lane = 0; lane < kPacket; ++lane) {
          valid[lane] = base + lane < camera.width ? -1 : 0;
          const Eigen::Vector3f direction =
              (row_ray + (base + lane) * ray_from_pixel.col(0)).cast<float>();
          rays.ray.org_x[lane] = center.x();
          rays.ray.org_y[lane] = center.y();
          rays.ray.org_z[lane] = center.z();
          rays.ray.dir_x[lane] = direction.x();
          rays.ray.dir_y[lane] = direction.y();
          rays.ray.dir_z[lane] = direction.z();
          rays.ray.tnear[lane] = 0.0F;
          rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
          rays.ray.time[lane] = 0.0F;
          rays.ray.mask[lane] = ~0U;
          rays.ray.id[lane] = 0;
          rays.ray.flags[lane] = 0;
          rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
          rays.hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect8(valid, impl_->embree.scene(), &context, &rays);
        for (int lane = 0; lane < kPacket && base + lane < camera.width; ++lane) {
          if (rays.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
          facets(y, base + lane) = static_cast<int>(rays.hit.primID[lane]);
        }
      }
    }
  });
  return facets;
}

std::vector<ViewDomain> RayCaster::Cast(const std::vector<Camera>& cameras,
                                        const std::vector<CameraPair>& pairs, double border_px,
                                        const std::vector<cv::Mat>& masks,
                                        const std::vector<CameraPair>& other_pairs,
                                        std::vector<ViewPartners>* others) const {
  std::vector<ViewDomain> domains(cameras.size());
  std::vector<char> used(cameras.size(), 0);
  std::vector<char> reference(cameras.size(), 0);
  for (const CameraPair& pair : pairs) {
    domains[pair.reference].seconds.push_back(pair.second);
    used[pair.reference] = used[pair.second] = reference[pair.reference] = 1;
  }
  if (others != nullptr) {
    others->assign(cameras.size(), ViewPartners());
    for (const CameraPair& pair : other_pairs) {
      (*others)[pair.reference].seconds.push_back(pair.second);
      used[pair.reference] = used[pair.second] = reference[pair.reference] = 1;
    }
  }
  std::vector<std::vector<uint8_t>> facing(cameras.size());
  ParallelFor(static_cast<int>(cameras.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (used[i] != 0) facing[i] = impl_->FacesTarget(cameras[i].Center());
    }
  });
  std::vector<cv::Mat1i> facet_maps(cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    domains[i].width = cameras[i].width;
    domains[i].height = cameras[i].height;
    if (used[i] == 0) continue;
    facet_maps[i] = FacetMap(cameras[i]);
    ParallelFor(cameras[i].height, kRowGrain, [&](int begin, int end) {
      cv::Mat1i rows = facet_maps[i].rowRange(begin, end);
      for (int& facet : rows) {
        if (facet >= 0 && facing[i][facet] == 0) facet = -1;
      }
    });
  }
  ParallelFor(static_cast<int>(cameras.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (reference[i] == 0) {
        domains[i].start.assign(1, 0);
      } else {
        impl_->BuildPixelLists(cameras[i], facet_maps[i], &domains[i]);
      }
    }
  });
  for (size_t i = 0; i < cameras.size(); ++i) {
    std::vector<ViewPartners*> sets = {&domains[i]};
    if (others != nullptr) sets.push_back(&(*others)[i]);
    for (ViewPartners* partners : sets) {
      if (partners->seconds.empty()) continue;
      impl_->CastPairs(cameras, static_cast<int>(i), facing, facet_maps, masks, border_px,
                       domains[i], partners);
    }
  }
  return domains;
}

void RayCaster::PointsVisible(const Eigen::Vector3d& center,
                              const std::vector<Eigen::Vector3d>& points,
                              const std::vector<int>& facets, std::vector<uint8_t>* visible) const {
  const std::vector<uint8_t> faces_target = impl_->FacesTarget(center);
  visible->resize(points.size());
  ParallelFor(static_cast<int>(points.size()), kPointGrain, [&](int begin, int end) {
    impl_->CastOcclusion(center, faces_target, points.data() + begin, facets.data() + begin,
                         end - begin, visible->data() + begin);
  });
}

}  // namespace burin
