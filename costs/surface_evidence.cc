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

// Where the depth steps of a view are not.
struct StepsOfView {
  cv::Mat1f distance;  // of each pixel to one, at most the picture's diagonal
  cv::Mat1b clear;     // 255 where it is kClearPx or more
  cv::Mat1b
      off_step;  // likewise, of the steps that the facets' planes do not predict (costs/step_band.h)
};

StepsOfView FindSteps(const FrozenSurface& surface, size_t view) {
  const ViewDomain& domain = surface.domains[view];
  const Camera& camera = surface.views[view].camera;
  const std::vector<uint8_t> open = OpenBorderPixels(domain, surface.mesh, surface.boundary);
  DepthPlanes planes = MakeDepthPlanes(domain, surface.mesh, camera, /*ray_lengths=*/false);
  StepsOfView steps;
  steps.off_step = StepDistances(planes, open, kStepPx) >= kClearPx;
  std::fill(planes.slope_x.begin(), planes.slope_x.end(), 0.0F);
  std::fill(planes.slope_y.begin(), planes.slope_y.end(), 0.0F);
  steps.distance =
      cv::min(StepDistances(planes, open, kStepPx), std::hypot(camera.width, camera.height));
  steps.clear = steps.distance >= kClearPx;
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

// What pairs of one view see of a facet: bits of up to eight partners.
struct SeenBits {
  unsigned any = 0;
  unsigned clear = 0;
  unsigned off_step = 0;
};

SeenBits UniteBits(const PixelRange& pixels, const uint8_t* partners, const StepsOfView& steps) {
  SeenBits seen;
  for (const ImagePixel pixel : pixels) {
    const unsigned bits = partners[pixel.index];
    seen.any |= bits;
    seen.clear |= bits & steps.clear.data[pixel.index];
    seen.off_step |= bits & steps.off_step.data[pixel.index];
  }
  return seen;
}

// Counts the view's pairs by facet.
void CountPairs(const FrozenSurface& surface, size_t view, const StepsOfView& steps,
                std::vector<FacetEvidence>* facets) {
  const ViewDomain& domain = surface.domains[view];
  const TriangleMesh& mesh = surface.mesh;
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const int f = domain.facet[k];
      const Eigen::Vector3i& face = mesh.faces[f];
      const Eigen::Vector3d normal = FaceAreaNormal(mesh, f).normalized();
      const Eigen::Vector3d middle =
          (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
      const auto cosine = [&](size_t of) {
        return normal.dot((surface.views[of].camera.Center() - middle).normalized());
      };
      FacetEvidence& facet = (*facets)[f];
      for (size_t first = 0; first < domain.seconds.size(); first += 8) {
        const SeenBits seen =
            UniteBits(domain.PixelsOf(k), domain.second_visible.Of(first).bytes, steps);
        facet.pairs += __builtin_popcount(seen.any);
        facet.clear_pairs += __builtin_popcount(seen.clear);
        facet.off_step_pairs += __builtin_popcount(seen.off_step);
        for (size_t b = first; b < std::min(first + 8, domain.seconds.size()); ++b) {
          if ((seen.any >> (b - first) & 1U) == 0) continue;
          const double smaller = std::min(cosine(view), cosine(domain.seconds[b]));
          facet.cosine = std::max(facet.cosine, static_cast<float>(smaller));
        }
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
    LookAtVertices(surface, i, steps.distance, normals, &evidence);
  }
  return evidence;
}

}  // namespace burin
