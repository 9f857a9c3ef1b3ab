#include "core/evidence/window_places.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/evidence/window_matches.h"
#include "core/image/mask_cover.h"
#include "core/support/counter_random.h"
#include "core/visibility/facet_map.h"

namespace burin {
namespace {

constexpr int kGradient = 3;            // Sobel's size
constexpr double kLeastCosine = 0.17;   // between normal and view: 80 degrees
constexpr double kSmallestWarp = 0.15;  // area that a window's pixel covers in the other view
constexpr double kLargestWarp = 6;

// The facet map of every second pixel, whose centres are the corners between pixels.
constexpr int kMapStep = 2;

bool Surrounded(const cv::Mat1i& facets, int x, int y) {
  constexpr int kReach = (kWindowRadius + kMapStep - 1) / kMapStep;
  if (x < kReach || y < kReach || x + kReach >= facets.cols || y + kReach >= facets.rows) {
    return false;
  }
  for (int v = y - kReach; v <= y + kReach; v += kReach) {
    for (int u = x - kReach; u <= x + kReach; u += kReach) {
      if (facets(v, u) < 0) return false;
    }
  }
  return true;
}

}  // namespace

bool SmallView::MayHoldWindow(const Eigen::Vector2d& at) const {
  if (!InsideForSampling(image, at)) return false;
  return whole.empty() || whole(static_cast<int>(at.y()), static_cast<int>(at.x())) != 0;
}

SmallView Reduce(const View& view, int largest_side_px) {
  SmallView small;
  int shrink = 1;
  while (std::max(view.camera.width, view.camera.height) > shrink * largest_side_px) shrink *= 2;
  const cv::Size size(std::max(1, view.camera.width / shrink),
                      std::max(1, view.camera.height / shrink));
  cv::Mat reduced = view.gray;
  if (shrink > 1) cv::resize(view.gray, reduced, size, 0, 0, cv::INTER_AREA);
  reduced.convertTo(small.image, CV_32F);
  small.camera = view.camera.Resized(size.width, size.height);
  small.pixel = {static_cast<double>(view.camera.width) / size.width,
                 static_cast<double>(view.camera.height) / size.height};
  if (!view.mask.empty()) {
    const cv::Mat used = MaskCover(view.mask, size) > kWholePixel;
    cv::erode(used, small.whole, cv::Mat::ones(kWindowSide + 2, kWindowSide + 2, CV_8U));
  }
  return small;
}

std::vector<WindowPlace> PlacesOf(const TriangleMesh& mesh, const SmallView& view, int index,
                                  int count) {
  const Camera map_camera = view.camera.Resized(std::max(1, view.camera.width / kMapStep),
                                                std::max(1, view.camera.height / kMapStep));
  const cv::Mat1i facets = FacetMap(mesh, map_camera);
  const auto seen = static_cast<double>(facets.total() - cv::countNonZero(facets == -1));
  if (seen == 0) return {};
  const int step = std::max(2, static_cast<int>(std::sqrt(seen / count)));
  cv::Mat1f texture;
  cv::cornerMinEigenVal(view.image, texture, kWindowSide, kGradient);
  const Eigen::Vector3d center = view.camera.Center();
  const double to_x = static_cast<double>(view.camera.width) / map_camera.width;
  const double to_y = static_cast<double>(view.camera.height) / map_camera.height;
  std::vector<WindowPlace> places;
  for (int top = 0; top < facets.rows; top += step) {
    for (int left = 0; left < facets.cols; left += step) {
      WindowPlace best;
      for (int y = top; y < std::min(top + step, facets.rows); ++y) {
        for (int x = left; x < std::min(left + step, facets.cols); ++x) {
          if (facets(y, x) < 0) continue;
          const Eigen::Vector2d at((x + 0.5) * to_x, (y + 0.5) * to_y);
          if (!view.MayHoldWindow(at)) continue;
          const float here = texture(static_cast<int>(at.y()), static_cast<int>(at.x()));
          if (here <= best.texture || !Surrounded(facets, x, y)) continue;
          best.at = at;
          best.facet = facets(y, x);
          best.texture = here;
        }
      }
      if (best.facet < 0) continue;
      const Eigen::Vector3d normal = FaceAreaNormal(mesh, best.facet);
      const Eigen::Vector3d ray = view.camera.Ray(best.at.x(), best.at.y());
      const double depth =
          normal.dot(mesh.vertices[mesh.faces[best.facet][0]] - center) / normal.dot(ray);
      best.point = center + depth * ray;
      if (!(depth > 0) || !best.point.allFinite()) continue;
      best.order = CounterRandom(0, index).Bits(places.size());
      places.push_back(best);
    }
  }
  return places;
}

std::vector<int> PlacesSeenFrom(const FacetRays& rays, const SmallView& j,
                                const std::vector<uint8_t>& facing,
                                const std::vector<WindowPlace>& places) {
  std::vector<int> seen;
  std::vector<Eigen::Vector3d> points;
  std::vector<int> facets;
  for (size_t k = 0; k < places.size(); ++k) {
    const WindowPlace& place = places[k];
    if (j.camera.Depth(place.point) <= 0 || !j.MayHoldWindow(j.camera.Project(place.point))) {
      continue;
    }
    seen.push_back(static_cast<int>(k));
    points.push_back(place.point);
    facets.push_back(place.facet);
  }
  std::vector<uint8_t> visible(points.size());
  rays.CastToCamera(j.camera, facing, points.data(), facets.data(), static_cast<int>(points.size()),
                    visible.data());
  size_t kept = 0;
  for (size_t k = 0; k < seen.size(); ++k) {
    if (visible[k] != 0) seen[kept++] = seen[k];
  }
  seen.resize(kept);
  return seen;
}

std::vector<CameraPair> FirstPartners(const Scene& scene, const std::vector<CameraPair>& pairs,
                                      int count) {
  std::vector<int> partners(scene.views.size(), 0);
  const auto large_enough = [&](int view) {
    const Camera& camera = scene.views[view].camera;
    return std::max(camera.width, camera.height) >= kLeastSidePx;
  };
  std::vector<CameraPair> first;
  for (const CameraPair& pair : pairs) {
    if (!large_enough(pair.reference) || !large_enough(pair.second)) continue;
    if (partners[pair.reference]++ < count) first.push_back(pair);
  }
  return first;
}

std::optional<WarpedWindow> WarpThroughPlane(const SmallView& i, const SmallView& j,
                                             const Eigen::Vector2d& at,
                                             const Eigen::Vector3d& point,
                                             const Eigen::Vector3d& normal, double least_cosine) {
  const Eigen::Vector3d center = i.camera.Center();
  const Eigen::Vector3d to_i = center - point;
  const Eigen::Vector3d to_j = j.camera.Center() - point;
  if (normal.dot(to_i) < kLeastCosine * to_i.norm() ||
      normal.dot(to_j) < kLeastCosine * to_j.norm() ||
      to_i.dot(to_j) < least_cosine * to_i.norm() * to_j.norm()) {
    return std::nullopt;
  }
  const auto through = [&](double x, double y) -> Eigen::Vector2d {
    const Eigen::Vector3d ray = i.camera.Ray(x, y);
    return j.camera.Project(center - normal.dot(to_i) / normal.dot(ray) * ray);
  };
  const Eigen::Vector2d middle = through(at.x(), at.y());
  Eigen::Matrix2d jacobian;
  jacobian.col(0) = through(at.x() + 1, at.y()) - middle;
  jacobian.col(1) = through(at.x(), at.y() + 1) - middle;
  const double area = jacobian.determinant();
  if (!(area > kSmallestWarp && area < kLargestWarp)) return std::nullopt;
  const Eigen::Vector2d line = j.camera.Project(center - 1.001 * to_i) - middle;
  const Eigen::Vector2d in_i = jacobian.inverse() * line;
  if (!(in_i.norm() > 1e-9)) return std::nullopt;
  WarpedWindow window;
  window.at_i.center = at;
  window.at_i.along = in_i.normalized();
  window.at_i.across = {-window.at_i.along.y(), window.at_i.along.x()};
  window.at_j.center = middle;
  window.at_j.along = jacobian * window.at_i.along;
  window.at_j.across = jacobian * window.at_i.across;
  return window;
}

}  // namespace burin
