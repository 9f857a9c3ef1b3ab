#include "costs/surface_evidence.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/support/parallel.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/facet_pencil.h"
#include "costs/step_band.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;
constexpr int kVertexGrain = 1024;

// Distance to the nearest pixel that the mask allows; empty without a mask.
cv::Mat1f DistanceOutside(const cv::Mat& mask) {
  cv::Mat1f distance;
  if (mask.empty()) return distance;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

// Distances of a view's pixels to depth steps, at most the picture's diagonal.
struct StepsOfView {
  cv::Mat1f any;       // kStepPx from pixel to pixel
  cv::Mat1f off_step;  // those that the facets' planes do not predict (costs/step_band.h)
};

StepsOfView FindSteps(const FrozenSurface& surface, size_t view) {
  const ViewDomain& domain = surface.domains[view];
  const Camera& camera = surface.views[view].camera;
  const std::vector<uint8_t> open = OpenBorderPixels(domain, surface.mesh, surface.boundary);
  DepthPlanes planes = MakeDepthPlanes(domain, surface.mesh, camera, /*ray_lengths=*/false);
  const double diagonal = std::hypot(camera.width, camera.height);
  StepsOfView steps;
  steps.off_step = cv::min(StepDistances(planes, open, kStepPx), diagonal);
  std::fill(planes.slope_x.begin(), planes.slope_x.end(), 0.0F);
  std::fill(planes.slope_y.begin(), planes.slope_y.end(), 0.0F);
  steps.any = cv::min(StepDistances(planes, open, kStepPx), diagonal);
  return steps;
}

void CountPixels(const TriangleMesh& mesh, const LevelView& view,
                 std::vector<FacetEvidence>* facets) {
  const cv::Mat1i seen = FacetMap(mesh, view.camera);
  const std::vector<uint8_t> facing = FacingFacets(mesh, view.camera.Center());
  const cv::Mat1f outside = DistanceOutside(view.mask);
  for (int y = 0; y < seen.rows; ++y) {
    for (int x = 0; x < seen.cols; ++x) {
      const int f = seen(y, x);
      if (f < 0) continue;
      FacetEvidence& facet = (*facets)[f];
      if (facing[f] == 0) {
        ++facet.behind;
        continue;
      }
      ++facet.front;
      if (!outside.empty() && outside(y, x) > kClearPx) ++facet.outside;
    }
  }
}

// Counts the view's pairs by facet.
void CountPairs(const FrozenSurface& surface, size_t view, const StepsOfView& steps,
                std::vector<FacetEvidence>* facets) {
  const ViewDomain& domain = surface.domains[view];
  const TriangleMesh& mesh = surface.mesh;
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    PartnerBits any(domain.seconds.size(), 1);
    PartnerBits clear(domain.seconds.size(), 1);
    PartnerBits off_step(domain.seconds.size(), 1);
    for (int k = begin; k < end; ++k) {
      any.ClearAll(0);
      clear.ClearAll(0);
      off_step.ClearAll(0);
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        any.Unite(0, domain.second_visible, pixel.index, 1);
        if (steps.off_step(pixel.row, pixel.column) >= kClearPx) {
          off_step.Unite(0, domain.second_visible, pixel.index, 1);
        }
        if (steps.any(pixel.row, pixel.column) >= kClearPx) {
          clear.Unite(0, domain.second_visible, pixel.index, 1);
        }
      }
      if (any.Count(0) == 0) continue;
      const int f = domain.facet[k];
      const Eigen::Vector3i& face = mesh.faces[f];
      const Eigen::Vector3d normal = FaceAreaNormal(mesh, f).normalized();
      const Eigen::Vector3d middle =
          (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
      const auto cosine = [&](size_t of) {
        return normal.dot((surface.views[of].camera.Center() - middle).normalized());
      };
      FacetEvidence& facet = (*facets)[f];
      facet.pairs += any.Count(0);
      facet.clear_pairs += clear.Count(0);
      facet.off_step_pairs += off_step.Count(0);
      for (size_t b = 0; b < domain.seconds.size(); ++b) {
        if (!any.Test(b, 0)) continue;
        const double smaller = std::min(cosine(view), cosine(domain.seconds[b]));
        facet.cosine = std::max(facet.cosine, static_cast<float>(smaller));
      }
    }
  });
}

// The view's part in what is known of vertices.
void LookAtVertices(const FrozenSurface& surface, size_t view, const cv::Mat1f& step_distance,
                    const std::vector<Eigen::Vector3d>& normals, SurfaceEvidence* evidence) {
  std::vector<char> visible(surface.mesh.faces.size(), 0);
  for (const int f : surface.domains[view].facet) visible[f] = 1;
  const Camera& camera = surface.views[view].camera;
  const double full_px = std::ldexp(1.0, surface.views[view].at.halvings);
  ParallelFor(static_cast<int>(normals.size()), kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      if (std::none_of(surface.faces.Begin(v), surface.faces.End(v),
                       [&](int f) { return visible[f] != 0; })) {
        continue;
      }
      const Eigen::Vector3d& vertex = surface.mesh.vertices[v];
      const double cosine = normals[v].dot((camera.Center() - vertex).normalized());
      evidence->cosine[v] = std::max(evidence->cosine[v], static_cast<float>(cosine));
      if (camera.Depth(vertex) <= 0) continue;
      const Eigen::Vector2d at = camera.Project(vertex);
      if (!camera.Contains(at)) continue;
      const int x = std::min(camera.width - 1, static_cast<int>(at.x()));
      const int y = std::min(camera.height - 1, static_cast<int>(at.y()));
      const auto distance = static_cast<float>(full_px * step_distance(y, x));
      evidence->step_px[v] = std::max(evidence->step_px[v], distance);
    }
  });
}

}  // namespace

SurfaceEvidence MeasureSurfaceEvidence(const FrozenSurface& surface) {
  SurfaceEvidence evidence;
  evidence.facets.resize(surface.mesh.faces.size());
  evidence.cosine.assign(surface.mesh.vertices.size(), 0);
  evidence.step_px.assign(surface.mesh.vertices.size(), 0);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(surface.mesh, surface.faces);
  for (size_t i = 0; i < surface.views.size(); ++i) {
    const LevelView& view = surface.views[i];
    if (!view.at.takes_part) continue;
    CountPixels(surface.mesh, view, &evidence.facets);
    const StepsOfView steps = FindSteps(surface, i);
    CountPairs(surface, i, steps, &evidence.facets);
    LookAtVertices(surface, i, steps.any, normals, &evidence);
  }
  return evidence;
}

}  // namespace burin
