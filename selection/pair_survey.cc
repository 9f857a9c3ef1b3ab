#include "selection/pair_survey.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>

#include "core/image/mask_cover.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/visibility.h"

namespace burin {
namespace {

// What is held at a time: depth maps, pixel lists and bits of Omega_ij. More views than fit are looked from
// again.
constexpr size_t kBytesAtOnce = size_t{128} << 20;
constexpr size_t kMapBytes = 8;    // a pixel of a view: facet and depth
constexpr size_t kListBytes = 16;  // a pixel of a reference: lists, and what is in work

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

// Means over Omega_ij of view i, `reference`, and each of its partners, in their order.
std::vector<PairMeasure> Integrate(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                                   int reference, const ViewDomain& domain,
                                   const ParallaxRange& range) {
  struct Partner {
    Eigen::Vector3d center;
    double focal_px;
    PartnerPixels region;
    PairSums sums;
  };
  std::vector<Partner> partners;
  for (size_t b = 0; b < domain.seconds.size(); ++b) {
    const Camera& camera = cameras[domain.seconds[b]];
    partners.push_back({camera.Center(), FocalPx(camera), domain.second_visible.Of(b), {}});
  }
  const Camera& camera = cameras[reference];
  const Eigen::Vector3d center = camera.Center();
  const double focal_px = FocalPx(camera);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    const Eigen::Vector3i& face = mesh.faces[domain.facet[k]];
    const Eigen::Vector3d normal = FaceAreaNormal(mesh, domain.facet[k]).normalized();
    const double height = normal.dot(mesh.vertices[face[0]] - center);
    for (const ImagePixel pixel : domain.PixelsOf(k)) {
      if (!domain.second_visible.Any(pixel.index)) continue;
      const Eigen::Vector3d ray = camera.Ray(pixel.x(), pixel.y());
      const Eigen::Vector3d x = center + ray * (height / normal.dot(ray));
      const PointSight sight(center, focal_px, x, normal);
      for (Partner& partner : partners) {
        if (!partner.region.Has(pixel.index)) continue;
        partner.sums.Add(sight, {partner.center, partner.focal_px, x, normal}, range);
      }
    }
  }
  std::vector<PairMeasure> means;
  means.reserve(partners.size());
  const double image_points = static_cast<double>(domain.width) * domain.height;
  for (const Partner& partner : partners) means.push_back(partner.sums.Mean(image_points));
  return means;
}

}  // namespace

PairSurveyor::PairSurveyor(const Scene& scene, const TriangleMesh& mesh,
                           const SurveyOptions& options, const Wanted& wanted)
    : mesh_(mesh),
      options_(options),
      has_facets_(wanted.facets),
      cameras_(SurveyCameras(scene, options.resolution_px)),
      masks_(SurveyMasks(scene, cameras_)),
      caster_(mesh),
      estimate_(mesh, wanted.points ? static_cast<int>(cameras_.size()) : 0, options.parallax) {
  const int n = static_cast<int>(cameras_.size());
  survey_.view_count = n;
  survey_.measures.resize(static_cast<size_t>(n) * n);
  measured_.resize(survey_.measures.size(), 0);
  survey_.seen.assign(n, 0);
  if (wanted.facets) survey_.facets = FacetSets(n, static_cast<int>(mesh.faces.size()));
  std::vector<Eigen::Vector3d> centroids;
  for (const Eigen::Vector3i& face : mesh.faces) {
    centroids.emplace_back(
        (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3);
  }
  ParallelFor(n, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) LookFrom(i, centroids, wanted);
  });
}

void PairSurveyor::LookFrom(int view, const std::vector<Eigen::Vector3d>& centroids,
                            const Wanted& wanted) {
  const Camera& camera = cameras_[view];
  const cv::Mat& mask = masks_[view];
  const Eigen::Vector3d center = camera.Center();
  cv::Mat1f inverse_depth;
  cv::Mat1i facet_map = FacetMap(mesh_, camera, &inverse_depth);
  int64_t front = 0;
  for (int y = 0; y < facet_map.rows; ++y) {
    for (int x = 0; x < facet_map.cols; ++x) {
      int& facet = facet_map(y, x);
      if (facet < 0) continue;
      if (FaceAreaNormal(mesh_, facet).dot(center - centroids[facet]) <= 0) {
        facet = -1;
        continue;
      }
      if (wanted.facets) survey_.facets.Insert(view, facet);
      if (!mask.empty() && mask.at<uint8_t>(y, x) == 0) {
        facet = -1;
        continue;
      }
      ++front;
    }
  }
  survey_.seen[view] = static_cast<double>(front) / static_cast<double>(facet_map.total());
  if (wanted.points) {
    estimate_.Look(view, camera, mask, facet_map, inverse_depth, survey_.seen[view]);
  }
  if (wanted.facets) AddHiddenFacets(view, centroids);
}

// Those that no pixel hits but whose centroid is visible.
void PairSurveyor::AddHiddenFacets(int view, const std::vector<Eigen::Vector3d>& centroids) {
  const Camera& camera = cameras_[view];
  std::vector<Eigen::Vector3d> points;
  std::vector<int> facets;
  for (size_t f = 0; f < centroids.size(); ++f) {
    if (survey_.facets.Contains(view, static_cast<int>(f)) || camera.Depth(centroids[f]) <= 0 ||
        !camera.Contains(camera.Project(centroids[f]))) {
      continue;
    }
    points.push_back(centroids[f]);
    facets.push_back(static_cast<int>(f));
  }
  std::vector<uint8_t> visible;
  caster_.PointsVisible(camera, points, facets, &visible);
  for (size_t k = 0; k < facets.size(); ++k) {
    if (visible[k] != 0) survey_.facets.Insert(view, facets[k]);
  }
}

bool PairSurveyor::MeasureAllOf(const std::vector<int>& references) {
  std::vector<CameraPair> pairs;
  pairs.reserve(references.size() * survey_.view_count);
  for (const int i : references) {
    for (int j = 0; j < survey_.view_count; ++j) pairs.push_back({i, j});
  }
  return Measure(pairs);
}

bool PairSurveyor::Measure(const std::vector<CameraPair>& pairs) {
  const int n = survey_.view_count;
  std::vector<std::vector<int>> seconds(n);
  bool any = false;
  for (const auto& [i, j] : pairs) {
    char& measured = measured_[static_cast<size_t>(i) * n + j];
    if (i == j || measured != 0) continue;
    measured = any = true;
    if (!has_facets_ || survey_.facets.CountShared(i, j) > 0) seconds[i].push_back(j);
  }
  std::vector<CameraPair> together;
  std::vector<char> looked(n, 0);
  size_t bytes = 0;
  for (int i = 0; i < n; ++i) {
    if (seconds[i].empty()) continue;
    const auto look = [&](int view) {
      if (looked[view] != 0) return;
      looked[view] = 1;
      bytes += kMapBytes * cameras_[view].width * cameras_[view].height + mesh_.faces.size();
    };
    look(i);
    for (const int j : seconds[i]) {
      look(j);
      together.push_back({i, j});
    }
    bytes += (kListBytes + PartnerBits::BytesPerPixel(seconds[i].size())) * cameras_[i].width *
             cameras_[i].height;
    if (bytes < kBytesAtOnce) continue;
    MeasureTogether(together);
    together.clear();
    looked.assign(n, 0);
    bytes = 0;
  }
  if (!together.empty()) MeasureTogether(together);
  return any;
}

void PairSurveyor::MeasureTogether(const std::vector<CameraPair>& pairs) {
  const int n = survey_.view_count;
  const std::vector<ViewDomain> domains = caster_.Cast(cameras_, pairs, 0, masks_);
  ParallelFor(n, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::vector<int>& seconds = domains[i].seconds;
      if (seconds.empty()) continue;
      const std::vector<PairMeasure> means =
          Integrate(mesh_, cameras_, i, domains[i], options_.parallax);
      for (size_t b = 0; b < seconds.size(); ++b) {
        survey_.measures[static_cast<size_t>(i) * n + seconds[b]] = means[b];
      }
    }
  });
}

std::vector<int> AllViews(int view_count) {
  std::vector<int> views(view_count);
  std::iota(views.begin(), views.end(), 0);
  return views;
}

PairSurvey SurveyPairs(const Scene& scene, const TriangleMesh& mesh, const SurveyOptions& options) {
  PairSurveyor surveyor(scene, mesh, options, {/*facets=*/true, /*points=*/false});
  surveyor.MeasureAllOf(AllViews(static_cast<int>(scene.views.size())));
  return surveyor.Take();
}

}  // namespace burin
