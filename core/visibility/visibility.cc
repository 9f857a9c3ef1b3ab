#include "core/visibility/visibility.h"

#include <algorithm>
#include <utility>

#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/facet_rays.h"
#include "core/visibility/pair_region.h"

namespace burin {
namespace {

constexpr int kPointGrain = 4096;
constexpr int kViewsAtOnce = 4;  // bounds what drawing them takes

std::vector<ViewPixels> LookFromViews(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                                      const std::vector<cv::Mat>& masks,
                                      const std::vector<char>& used) {
  std::vector<ViewPixels> views(cameras.size());
  std::vector<int> drawn;
  for (size_t i = 0; i < cameras.size(); ++i) {
    views[i].camera = cameras[i];
    if (!masks.empty()) views[i].mask = masks[i];
    if (used[i] != 0) drawn.push_back(static_cast<int>(i));
  }
  const auto count = static_cast<int>(drawn.size());
  for (int first = 0; first < count; first += kViewsAtOnce) {
    ParallelFor(std::min(kViewsAtOnce, count - first), 1, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        ViewPixels& view = views[drawn[first + k]];
        view.domain.ListPixels(mesh, view.camera, CornerMap(mesh, view.camera), &view.behind);
      }
    });
  }
  return views;
}

// A set of Omega_ij of a view i, and which of its partners a view is.
struct PartnerOf {
  int first;
  ViewPartners* partners;
  size_t index;
};

}  // namespace

RayCaster::RayCaster(const TriangleMesh& mesh) : rays_(std::make_unique<FacetRays>(mesh)) {}

RayCaster::~RayCaster() = default;

std::vector<ViewDomain> RayCaster::Cast(const std::vector<Camera>& cameras,
                                        const std::vector<CameraPair>& pairs, double border_px,
                                        const std::vector<cv::Mat>& masks,
                                        const std::vector<CameraPair>& other_pairs,
                                        std::vector<ViewPartners>* others) const {
  std::vector<ViewPartners> own(cameras.size());
  if (others != nullptr) others->assign(cameras.size(), ViewPartners());
  std::vector<char> used(cameras.size(), 0);
  std::vector<std::vector<PartnerOf>> partner_of(cameras.size());
  const auto take = [&](const CameraPair& pair, ViewPartners* partners) {
    used[pair.reference] = used[pair.second] = 1;
    partner_of[pair.second].push_back({pair.reference, partners, partners->seconds.size()});
    partners->seconds.push_back(pair.second);
  };
  for (const CameraPair& pair : pairs) take(pair, &own[pair.reference]);
  if (others != nullptr) {
    for (const CameraPair& pair : other_pairs) take(pair, &(*others)[pair.reference]);
  }

  const TriangleMesh& mesh = rays_->mesh();
  std::vector<ViewPixels> views = LookFromViews(mesh, cameras, masks, used);
  for (size_t i = 0; i < cameras.size(); ++i) {
    for (ViewPartners* partners : {&own[i], others != nullptr ? &(*others)[i] : nullptr}) {
      if (partners == nullptr || partners->seconds.empty()) continue;
      const size_t pixels = static_cast<size_t>(cameras[i].width) * cameras[i].height;
      partners->second_visible = PartnerBits(partners->seconds.size(), pixels);
      partners->pair_pixels.resize(partners->seconds.size());
    }
  }
  SecondView second;
  for (size_t j = 0; j < cameras.size(); ++j) {
    if (partner_of[j].empty()) continue;
    second.Look(mesh, views[j]);
    for (const auto& [first, partners, index] : partner_of[j]) {
      partners->pair_pixels[index] =
          CastPair(*rays_, views[first], second, border_px, index, &partners->second_visible);
    }
  }
  std::vector<ViewDomain> domains(cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    const bool reference =
        !own[i].seconds.empty() || (others != nullptr && !(*others)[i].seconds.empty());
    if (reference) domains[i] = std::move(views[i].domain);
    static_cast<ViewPartners&>(domains[i]) = std::move(own[i]);
    domains[i].width = cameras[i].width;
    domains[i].height = cameras[i].height;
    if (!reference) domains[i].start.assign(1, 0);
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
