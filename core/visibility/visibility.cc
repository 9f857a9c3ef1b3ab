#include "core/visibility/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/support/parallel.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/facet_rays.h"

namespace burin {
namespace {

constexpr int kPointGrain = 4096;
constexpr int kRowGrain = 16;
constexpr int kFacetGrain = 512;
constexpr double kHiddenPx = 8;
constexpr double kNearest =
    0.1;  // of a point's depth: what hides it for certain, where the focal length is some pixels

// What one view says about all pairs that it is in.
struct ViewSight {
  Camera camera;
  cv::Mat mask;                 // empty = none
  std::vector<uint8_t> facing;  // FacingFacets() of its centre
  cv::Mat1i facet_map;          // of the facets that face it; -1 elsewhere
  cv::Mat1f inverse_depth;      // of what is seen, from whatever side; 0 = nothing
};

std::vector<ViewSight> LookFromViews(const FacetRays& rays, const std::vector<Camera>& cameras,
                                     const std::vector<cv::Mat>& masks,
                                     const std::vector<char>& used) {
  std::vector<ViewSight> sights(cameras.size());
  ParallelFor(static_cast<int>(cameras.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      sights[i].camera = cameras[i];
      if (!masks.empty()) sights[i].mask = masks[i];
      if (used[i] != 0) sights[i].facing = FacingFacets(rays.mesh(), cameras[i].Center());
    }
  });
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (used[i] == 0) continue;
    sights[i].facet_map = FacetMap(rays.mesh(), cameras[i], &sights[i].inverse_depth);
    ParallelFor(cameras[i].height, kRowGrain, [&](int begin, int end) {
      cv::Mat1i rows = sights[i].facet_map.rowRange(begin, end);
      for (int& facet : rows) {
        if (facet >= 0 && sights[i].facing[facet] == 0) facet = -1;
      }
    });
  }
  return sights;
}

// Inverse depth along the ray of every pixel; 0 = no facet.
cv::Mat1d InverseDepths(const TriangleMesh& mesh, const ViewRays& rays, const ViewDomain& domain) {
  cv::Mat1d inverse_depth(domain.height, domain.width, 0.0);
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const InverseDepthPlane plane =
          MakeFacetPencil(mesh.vertices, mesh.faces[domain.facet[k]], rays).InverseDepth();
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        inverse_depth(pixel.row, pixel.column) = plane.At(pixel.x(), pixel.y());
      }
    }
  });
  return inverse_depth;
}

// Surface points of a row that need a ray of their own.
struct RayQueue {
  std::vector<Eigen::Vector3d> points;
  std::vector<int> facets;
  std::vector<int> columns;
  std::vector<uint8_t> visible;
  void Clear() {
    points.clear();
    facets.clear();
    columns.clear();
  }
  void Add(const Eigen::Vector3d& point, int facet, int column) {
    points.push_back(point);
    facets.push_back(facet);
    columns.push_back(column);
  }
};

// Omega_ij of one pair, row by row of view i.
class PairRegion {
 public:
  PairRegion(const FacetRays& facet_rays, const ViewSight& first, const ViewRays& first_rays,
             const cv::Mat1d& inverse_depth, const ViewSight& second, double border_px)
      : facet_rays_(facet_rays),
        first_(first),
        rays_(first_rays),
        inverse_depth_(inverse_depth),
        second_(second),
        second_masked_(!second.mask.empty()),
        border_px_(border_px) {
    const Eigen::Matrix<double, 3, 4> projection = second.camera.ProjectionMatrix();
    second_from_ray_ = projection.leftCols<3>();
    epipole_ = second_from_ray_ * rays_.center + projection.col(3);
    const double focal = std::sqrt(second.camera.fx * second.camera.fy);
    hides_from_ = static_cast<float>(1 / std::max(1 - kHiddenPx / focal, kNearest));
  }

  // Sets the row's pixels of Omega_ij; returns how many.
  int64_t CastRow(int y, size_t partner, PartnerBits* bits, RayQueue* queue) const {
    const int width = first_.camera.width;
    const size_t row_start = static_cast<size_t>(y) * width;
    const int* facet_row = first_.facet_map[y];
    const double* inverse_row = inverse_depth_[y];
    const Eigen::Vector3d row_ray = rays_.ray_from_pixel * Eigen::Vector3d(0.5, y + 0.5, 1);
    const Eigen::Vector3d row_q = second_from_ray_ * row_ray;
    const Eigen::Vector3d step_q = second_from_ray_ * rays_.ray_from_pixel.col(0);
    const uint8_t* mask_row = first_.mask.empty() ? nullptr : first_.mask.ptr<uint8_t>(y);
    int64_t count = 0;
    queue->Clear();
    for (int x = 0; x < width; ++x) {
      const int facet = facet_row[x];
      if (facet < 0 || second_.facing[facet] == 0) continue;
      if (mask_row != nullptr && mask_row[x] == 0) continue;
      // Homogeneous image point in j, times the inverse depth.
      const Eigen::Vector3d q = row_q + static_cast<double>(x) * step_q + inverse_row[x] * epipole_;
      if (!(inverse_row[x] > 0) || !InSecondImage(q)) continue;
      const double scale = 1 / q.z();
      const Sight sight = SightAround(q.x() * scale, q.y() * scale, inverse_row[x] * scale, facet);
      if (sight == Sight::kHidden) continue;
      if (sight == Sight::kSeen) {
        bits->Set(partner, row_start + x);
        ++count;
        continue;
      }
      const Eigen::Vector3d ray = row_ray + static_cast<double>(x) * rays_.ray_from_pixel.col(0);
      queue->Add(rays_.center + ray / inverse_row[x], facet, x);
    }
    queue->visible.resize(queue->points.size());
    facet_rays_.CastToCamera(second_.camera, second_.facing, queue->points.data(),
                             queue->facets.data(), static_cast<int>(queue->points.size()),
                             queue->visible.data());
    for (size_t k = 0; k < queue->columns.size(); ++k) {
      if (queue->visible[k] == 0) continue;
      bits->Set(partner, row_start + queue->columns[k]);
      ++count;
    }
    return count;
  }

 private:
  // `q`, a homogeneous image point of j, is far enough inside and not masked. Here and below what is
  // not a number fails.
  bool InSecondImage(const Eigen::Vector3d& q) const {
    const int width = second_.camera.width;
    const int height = second_.camera.height;
    const double margin = border_px_ * q.z();
    const bool inside = q.z() > 0 && q.x() >= margin && q.y() >= margin &&
                        q.x() <= width * q.z() - margin && q.y() <= height * q.z() - margin;
    if (!inside) return false;
    if (!second_masked_) return true;
    const int column = std::clamp(static_cast<int>(q.x() / q.z()), 0, width - 1);
    const int row = std::clamp(static_cast<int>(q.y() / q.z()), 0, height - 1);
    return second_.mask.at<uint8_t>(row, column) != 0;
  }

  enum class Sight { kSeen, kHidden, kUnclear };

  // Of a point of `facet` at image point (x, y) of j and inverse depth 1/t there, by the four pixels around it. Seen: none
  // of them sees something nearer but `facet` itself or facets that share a vertex with it. Hidden: all of them see
  // something else, nearer by kHiddenPx pixel footprints.
  Sight SightAround(double x, double y, double inverse_depth, int facet) const {
    const cv::Mat1i& facet_map = second_.facet_map;
    const bool between_centres =
        x >= 0.5 && y >= 0.5 && x < facet_map.cols - 0.5 && y < facet_map.rows - 0.5;
    if (!between_centres) return Sight::kUnclear;
    const int column = static_cast<int>(x - 0.5);
    const int row = static_cast<int>(y - 0.5);
    const float* depths[2] = {second_.inverse_depth[row] + column,
                              second_.inverse_depth[row + 1] + column};
    const auto here = static_cast<float>(inverse_depth);
    const std::array<float, 4> around = {depths[0][0], depths[0][1], depths[1][0], depths[1][1]};
    const bool is_nearer[4] = {around[0] > here, around[1] > here, around[2] > here,
                               around[3] > here};
    if (!(is_nearer[0] || is_nearer[1] || is_nearer[2] || is_nearer[3])) return Sight::kSeen;
    const int* facets[2] = {facet_map[row] + column, facet_map[row + 1] + column};
    const std::array<int, 4> seen = {facets[0][0], facets[0][1], facets[1][0], facets[1][1]};
    const std::vector<Eigen::Vector3i>& faces = facet_rays_.mesh().faces;
    int others = 0;
    for (int k = 0; k < 4; ++k) {
      if (!is_nearer[k] || seen[k] == facet) continue;
      if (seen[k] < 0 || !ShareVertex(faces[seen[k]], faces[facet])) ++others;
    }
    if (others == 0) return Sight::kSeen;
    if (others < 4) return Sight::kUnclear;
    // depth - nearer > kHiddenPx * depth / focal.
    const float hidden = here * hides_from_;
    const bool all_hide =
        around[0] > hidden && around[1] > hidden && around[2] > hidden && around[3] > hidden;
    return all_hide ? Sight::kHidden : Sight::kUnclear;
  }

  const FacetRays& facet_rays_;
  const ViewSight& first_;
  const ViewRays& rays_;  // of the first
  const cv::Mat1d& inverse_depth_;
  const ViewSight& second_;
  const bool second_masked_;
  const double border_px_;
  Eigen::Matrix3d second_from_ray_;
  Eigen::Vector3d epipole_;
  float hides_from_;  // times the inverse depth
};

// Omega_ij of view `first` and each of its seconds.
void CastPartners(const FacetRays& facet_rays, const std::vector<ViewSight>& sights, int first,
                  double border_px, const ViewDomain& domain, ViewPartners* partners) {
  const ViewRays rays(sights[first].camera);
  const cv::Mat1d inverse_depth = InverseDepths(facet_rays.mesh(), rays, domain);
  partners->second_visible = PartnerBits(partners->seconds.size(), inverse_depth.total());
  for (size_t b = 0; b < partners->seconds.size(); ++b) {
    const PairRegion region(facet_rays, sights[first], rays, inverse_depth,
                            sights[partners->seconds[b]], border_px);
    std::vector<int64_t> row_count(domain.height, 0);
    ParallelFor(domain.height, kRowGrain, [&](int begin, int end) {
      RayQueue queue;
      for (int y = begin; y < end; ++y) {
        row_count[y] = region.CastRow(y, b, &partners->second_visible, &queue);
      }
    });
    partners->pair_pixels.push_back(
        std::accumulate(row_count.begin(), row_count.end(), int64_t{0}));
  }
}

}  // namespace

RayCaster::RayCaster(const TriangleMesh& mesh) : rays_(std::make_unique<FacetRays>(mesh)) {}

RayCaster::~RayCaster() = default;

std::vector<ViewDomain> RayCaster::Cast(const std::vector<Camera>& cameras,
                                        const std::vector<CameraPair>& pairs, double border_px,
                                        const std::vector<cv::Mat>& masks,
                                        const std::vector<CameraPair>& other_pairs,
                                        std::vector<ViewPartners>* others) const {
  std::vector<ViewDomain> domains(cameras.size());
  std::vector<char> used(cameras.size(), 0);
  std::vector<char> reference(cameras.size(), 0);
  const auto take = [&](const CameraPair& pair, ViewPartners* partners) {
    partners->seconds.push_back(pair.second);
    used[pair.reference] = used[pair.second] = reference[pair.reference] = 1;
  };
  for (const CameraPair& pair : pairs) take(pair, &domains[pair.reference]);
  if (others != nullptr) {
    others->assign(cameras.size(), ViewPartners());
    for (const CameraPair& pair : other_pairs) take(pair, &(*others)[pair.reference]);
  }

  const std::vector<ViewSight> sights = LookFromViews(*rays_, cameras, masks, used);
  ParallelFor(static_cast<int>(cameras.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      domains[i].width = cameras[i].width;
      domains[i].height = cameras[i].height;
      domains[i].start.assign(1, 0);
      if (reference[i] != 0) {
        domains[i].ListPixels(rays_->mesh(), cameras[i], sights[i].facet_map);
      }
    }
  });
  for (size_t i = 0; i < cameras.size(); ++i) {
    std::vector<ViewPartners*> sets = {&domains[i]};
    if (others != nullptr) sets.push_back(&(*others)[i]);
    for (ViewPartners* partners : sets) {
      if (partners->seconds.empty()) continue;
      CastPartners(*rays_, sights, static_cast<int>(i), border_px, domains[i], partners);
    }
  }
  return domains;
}

void RayCaster::PointsVisible(const Camera& camera, const std::vector<Eigen::Vector3d>& points,
                              const std::vector<int>& facets, std::vector<uint8_t>* visible) const {
  const std::vector<uint8_t> facing = FacingFacets(rays_->mesh(), camera.Center());
  visible->resize(points.size());
  ParallelFor(static_cast<int>(points.size()), kPointGrain, [&](int begin, int end) {
    rays_->CastToCamera(camera, facing, points.data() + begin, facets.data() + begin, end - begin,
                        visible->data() + begin);
  });
}

}  // namespace burin
