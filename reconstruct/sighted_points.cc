#include "reconstruct/sighted_points.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <numeric>

#include "core/support/error.h"
#include "core/support/median.h"

namespace burin {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr double kLatticeFootprints = 1.0 / 1024;

// The largest angle between two of the point's lines of sight.
double ParallaxDeg(const Eigen::Vector3d& point, const std::vector<int>& views,
                   const std::vector<Camera>& cameras) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(views.size());
  for (const int v : views) directions.push_back((cameras[v].Center() - point).normalized());
  double largest = 0;
  for (size_t i = 0; i < directions.size(); ++i) {
    for (size_t j = i + 1; j < directions.size(); ++j) {
      largest = std::max(largest, std::atan2(directions[i].cross(directions[j]).norm(),
                                             directions[i].dot(directions[j])));
    }
  }
  return largest * kDegrees;
}

// Mean distance of the point's projections from its measurements; 0 where there are none.
double MeanErrorPx(const Eigen::Vector3d& point, const Tracks::Range& track,
                   const std::vector<Camera>& cameras) {
  double sum = 0;
  for (const Measurement& measured : track) {
    sum += (cameras[measured.view].Project(point) - measured.image_point).norm();
  }
  return track.size() > 0 ? sum / static_cast<double>(track.size()) : 0;
}

bool IsBeforeAll(const Eigen::Vector3d& point, const std::vector<int>& views,
                 const std::vector<Camera>& cameras) {
  return std::all_of(views.begin(), views.end(),
                     [&](int v) { return cameras[v].Depth(point) > 0; });
}

struct PointCloud {
  const std::vector<Eigen::Vector3d>& points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t i, size_t axis) const { return points[i][static_cast<long>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};
using PointTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>,
                                        PointCloud, 3, size_t>;

}  // namespace

void SightedPoints::Add(const Eigen::Vector3d& position, const std::vector<int>& seen_by,
                        const std::vector<Camera>& cameras) {
  double footprint = cameras[seen_by[0]].Footprint(position);
  for (const int v : seen_by) footprint = std::min(footprint, cameras[v].Footprint(position));
  positions.push_back(position);
  footprints.push_back(footprint);
  views.insert(views.end(), seen_by.begin(), seen_by.end());
  begin.push_back(static_cast<int>(views.size()));
}

std::string SparseReport::Text() const {
  std::string text = std::to_string(Used()) + " of " + std::to_string(points) + " sparse points";
  std::string left_out;
  const auto name = [&left_out](int count, const char* what) {
    if (count == 0) return;
    left_out += (left_out.empty() ? ": " : ", ") + std::to_string(count) + " " + what;
  };
  name(without_views, "that no view sees");
  name(few_views, "that too few views see (start.min_views)");
  name(small_angle, "seen under too small an angle (start.min_angle_deg)");
  name(large_error, "too far from their measurements (start.max_error_px)");
  return text + (left_out.empty() ? "" : left_out + " are left out");
}

SightedPoints SparsePoints(const Scene& scene, const StartOptions& options, SparseReport* report) {
  const std::vector<Camera> cameras = CamerasOf(scene);
  SightedPoints used;
  report->points = static_cast<int>(scene.points.size());
  for (size_t p = 0; p < scene.points.size(); ++p) {
    const Eigen::Vector3d& position = scene.points[p].position;
    const std::vector<int>& views = scene.points[p].views;
    if (views.empty() || !IsBeforeAll(position, views, cameras)) {
      ++report->without_views;
    } else if (static_cast<int>(views.size()) < options.min_views) {
      ++report->few_views;
    } else if (ParallaxDeg(position, views, cameras) < options.min_angle_deg) {
      ++report->small_angle;
    } else if (MeanErrorPx(position, scene.tracks.Of(p), cameras) > options.max_error_px) {
      ++report->large_error;
    } else {
      used.Add(position, views, cameras);
    }
  }
  if (scene.points.empty()) throw InputError("the scene has no sparse points to make a mesh of");
  if (used.Count() == 0) throw InputError("no mesh can be made: " + report->Text());
  return used;
}

SightedPoints Merged(const SightedPoints& points, double share) {
  const int count = points.Count();
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return points.SightCount(a) > points.SightCount(b); });
  const PointCloud cloud{points.positions};
  const PointTree tree(3, cloud);
  std::vector<int> kept_as(count, -1);  // the point that each became
  for (const int p : order) {
    if (kept_as[p] >= 0) continue;
    kept_as[p] = p;
    const double radius = share * points.footprints[p];
    std::vector<std::pair<size_t, double>> near;
    tree.radiusSearch(points.positions[p].data(), radius * radius, near,
                      nanoflann::SearchParams(0, 0, false));
    for (const auto& [other, squared] : near) {
      const double least = share * std::min(points.footprints[p], points.footprints[other]);
      if (kept_as[other] < 0 && squared < least * least) kept_as[other] = p;
    }
  }
  std::vector<std::vector<int>> views(count);
  for (int p = 0; p < count; ++p) {
    std::vector<int>& of = views[kept_as[p]];
    of.insert(of.end(), points.views.begin() + points.begin[p],
              points.views.begin() + points.begin[p + 1]);
  }
  const double lattice =
      std::exp2(std::floor(std::log2(kLatticeFootprints * Median(points.footprints))));
  SightedPoints merged;
  for (int p = 0; p < count; ++p) {
    if (kept_as[p] != p) continue;
    std::sort(views[p].begin(), views[p].end());
    views[p].erase(std::unique(views[p].begin(), views[p].end()), views[p].end());
    merged.positions.emplace_back((points.positions[p] / lattice).array().round() * lattice);
    merged.footprints.push_back(points.footprints[p]);
    merged.views.insert(merged.views.end(), views[p].begin(), views[p].end());
    merged.begin.push_back(static_cast<int>(merged.views.size()));
  }
  return merged;
}

}  // namespace burin
