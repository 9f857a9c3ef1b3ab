#include "selection/pair_survey.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "core/image/mask_cover.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/visibility.h"

namespace burin {
namespace {

constexpr int kViewsAtOnce = 16;  // bounds the memory of the pixel lists and bits of Omega_ij

std::vector<Camera> SurveyCameras(const Scene& scene, int resolution_px) {
  std::vector<Camera> cameras;
  for (const View& view : scene.views) {
    const Camera& camera = view.camera;
    const double shrink =
        std::max(1.0, static_cast<double>(std::max(camera.width, camera.height)) / resolution_px);
    const auto size = [shrink](int pixels) {
      return std::max(1, static_cast<int>(std::lround(pixels / shrink)));
    };
    cameras.push_back(camera.Resized(size(camera.width), size(camera.height)));
  }
  return cameras;
}

// Masks at the size of the survey's cameras; empty where a view has none.
std::vector<cv::Mat> SurveyMasks(const Scene& scene, const std::vector<Camera>& cameras) {
  std::vector<cv::Mat> masks(cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (scene.views[i].mask.empty()) continue;
    masks[i] = MaskCover(scene.views[i].mask, {cameras[i].width, cameras[i].height}) >= kHalfPixel;
  }
  return masks;
}

// Facets of one view, and the share of its pixels that see a front side.
void SurveyView(const RayCaster& caster, const TriangleMesh& mesh,
                const std::vector<Eigen::Vector3d>& centroids, const Camera& camera,
                const cv::Mat& mask, int view, PairSurvey* survey) {
  const Eigen::Vector3d center = camera.Center();
  const cv::Mat1i facet_map = FacetMap(mesh, camera);
  int64_t front = 0;
  for (int y = 0; y < facet_map.rows; ++y) {
    for (int x = 0; x < facet_map.cols; ++x) {
      const int facet = facet_map(y, x);
      if (facet < 0 || FaceAreaNormal(mesh, facet).dot(center - centroids[facet]) <= 0) continue;
      survey->facets.Insert(view, facet);
      if (mask.empty() || mask.at<uint8_t>(y, x) != 0) ++front;
    }
  }
  survey->seen[view] = static_cast<double>(front) / static_cast<double>(facet_map.total());
  std::vector<Eigen::Vector3d> points;
  std::vector<int> facets;
  for (size_t f = 0; f < centroids.size(); ++f) {
    if (survey->facets.Contains(view, static_cast<int>(f)) || camera.Depth(centroids[f]) <= 0 ||
        !camera.Contains(camera.Project(centroids[f]))) {
      continue;
    }
    points.push_back(centroids[f]);
    facets.push_back(static_cast<int>(f));
  }
  std::vector<uint8_t> visible;
  caster.PointsVisible(camera, points, facets, &visible);
  for (size_t k = 0; k < facets.size(); ++k) {
    if (visible[k] != 0) survey->facets.Insert(view, facets[k]);
  }
}

// Means over Omega_ij, that of partner `b` in the domain of view i.
PairMeasure Integrate(const TriangleMesh& mesh, const Camera& camera_i, const Camera& camera_j,
                      const ViewDomain& domain, size_t b, const SurveyOptions& options) {
  const PartnerPixels region = domain.second_visible.Of(b);
  const Eigen::Vector3d center_i = camera_i.Center();
  const Eigen::Vector3d center_j = camera_j.Center();
  PairMeasure sum;
  int64_t count = 0;
  int64_t in_range = 0;
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    const Eigen::Vector3i& face = mesh.faces[domain.facet[k]];
    const Eigen::Vector3d normal = FaceAreaNormal(mesh, domain.facet[k]).normalized();
    const double height = normal.dot(mesh.vertices[face[0]] - center_i);
    for (const ImagePixel pixel : domain.PixelsOf(k)) {
      if (!region.Has(pixel.index)) continue;
      const Eigen::Vector3d ray = camera_i.Ray(pixel.x(), pixel.y());
      const Eigen::Vector3d x = center_i + ray * (height / normal.dot(ray));
      const double parallax = ParallaxDeg(center_i, center_j, x);
      ++count;
      if (parallax >= options.min_parallax_deg && parallax <= options.max_parallax_deg) ++in_range;
      sum.parallax_deg += parallax;
      for (const int form : {0, 1}) {
        const double difference =
            OrientedAngleDifferenceDeg(center_i, center_j, x, normal, form == 1);
        sum.symmetry_deg[form][0] += std::abs(difference);
        sum.symmetry_deg[form][1] += difference;
      }
      sum.resolution += ResolutionDiscrepancy(camera_i, camera_j, x, false);
      sum.resolution_printed += ResolutionDiscrepancy(camera_i, camera_j, x, true);
    }
  }
  PairMeasure mean;
  if (count == 0) return mean;
  const auto pixels = static_cast<double>(count);
  const double image = static_cast<double>(domain.width) * domain.height;
  mean.area = pixels / image;
  mean.area_in_range = static_cast<double>(in_range) / image;
  mean.parallax_deg = sum.parallax_deg / pixels;
  for (const int form : {0, 1}) {
    for (const int kind : {0, 1}) {
      mean.symmetry_deg[form][kind] = sum.symmetry_deg[form][kind] / pixels;
    }
  }
  mean.resolution = sum.resolution / pixels;
  mean.resolution_printed = sum.resolution_printed / pixels;
  return mean;
}

}  // namespace

PairSurvey SurveyPairs(const Scene& scene, const TriangleMesh& mesh, const SurveyOptions& options) {
  const int n = static_cast<int>(scene.views.size());
  PairSurvey survey;
  survey.view_count = n;
  survey.measures.resize(static_cast<size_t>(n) * n);
  survey.seen.assign(n, 0);
  survey.facets = FacetSets(n, static_cast<int>(mesh.faces.size()));
  const std::vector<Camera> cameras = SurveyCameras(scene, options.resolution_px);
  const std::vector<cv::Mat> masks = SurveyMasks(scene, cameras);
  std::vector<Eigen::Vector3d> centroids;
  for (const Eigen::Vector3i& face : mesh.faces) {
    centroids.emplace_back(
        (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3);
  }
  const RayCaster caster(mesh);
  ParallelFor(n, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      SurveyView(caster, mesh, centroids, cameras[i], masks[i], i, &survey);
    }
  });
  for (int first = 0; first < n; first += kViewsAtOnce) {
    std::vector<CameraPair> pairs;
    std::vector<size_t> slot;  // of a pair in its reference's list of seconds
    for (int i = first; i < std::min(n, first + kViewsAtOnce); ++i) {
      size_t next = 0;
      for (int j = 0; j < n; ++j) {
        if (i == j || survey.facets.CountShared(i, j) == 0) continue;
        pairs.push_back({i, j});
        slot.push_back(next++);
      }
    }
    const std::vector<ViewDomain> domains = caster.Cast(cameras, pairs, 0, masks);
    ParallelFor(static_cast<int>(pairs.size()), 1, [&](int begin, int end) {
      for (int p = begin; p < end; ++p) {
        const auto [i, j] = pairs[p];
        survey.measures[static_cast<size_t>(i) * n + j] =
            Integrate(mesh, cameras[i], cameras[j], domains[i], slot[p], options);
      }
    });
  }
  return survey;
}

}  // namespace burin
