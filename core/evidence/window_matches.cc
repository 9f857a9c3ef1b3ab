#include "core/evidence/window_matches.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/evidence/match_grid.h"
#include "core/image/mask_cover.h"
#include "core/support/counter_random.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_rays.h"

namespace burin {
namespace {

constexpr int kPartners = 4;            // of a view that are looked at
constexpr size_t kWindowsPerPair = 40;  // looked at, in scenes of up to 150 pairs;
constexpr size_t kFewestPerPair = 12;   // in large ones at least so many
constexpr size_t kWindows = 6000;       // and together about so many
constexpr int kPlacesPerView = 320;     // to choose them from
constexpr int kGradient = 3;            // Sobel's size
constexpr double kLeastContrast = 4;    // standard deviation of a window, grey levels
constexpr double kLeastCosine = 0.17;   // between normal and view: 80 degrees
constexpr double kLargestParallax = 35 * M_PI / 180;
constexpr size_t kEnough = 30;          // windows under that parallax, or others are looked at too
constexpr double kSmallestWarp = 0.15;  // area that a window's pixel covers in the other view
constexpr double kLargestWarp = 6;
constexpr double kClearScore = 0.6;
constexpr double kNearestChance = 15;
constexpr double kFarthestChance = 60;
constexpr int kChanceTries = 30;

// A photograph at the size that is looked at.
struct SmallView {
  Camera camera;
  cv::Mat1f image;
  cv::Mat1b whole;  // a window around the pixel has no masked one; empty = no mask
  double scale = 1;

  bool MayHoldWindow(const Eigen::Vector2d& at) const {
    if (!InsideForSampling(image, at)) return false;
    return whole.empty() || whole(static_cast<int>(at.y()), static_cast<int>(at.x())) != 0;
  }
};

// A window's centre, on the surface.
struct Place {
  Eigen::Vector2d at;
  int facet = -1;
  float texture = 0;
  Eigen::Vector3d point;
  uint64_t order = 0;  // random
};

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
  small.scale = static_cast<double>(view.camera.width) / size.width;
  if (!view.mask.empty()) {
    const cv::Mat used = MaskCover(view.mask, size) > kWholePixel;
    cv::erode(used, small.whole, cv::Mat::ones(kWindowSide + 2, kWindowSide + 2, CV_8U));
  }
  return small;
}

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

// The most textured place of every square of a grid that makes about kPlacesPerView squares of what the
// view sees of the mesh.
std::vector<Place> PlacesOf(const FacetRays& rays, const SmallView& view, int index) {
  const TriangleMesh& mesh = rays.mesh();
  const Camera map_camera = view.camera.Resized(std::max(1, view.camera.width / kMapStep),
                                                std::max(1, view.camera.height / kMapStep));
  const cv::Mat1i facets = rays.FacetMap(map_camera);
  const auto seen = static_cast<double>(facets.total() - cv::countNonZero(facets == -1));
  if (seen == 0) return {};
  const int step = std::max(2, static_cast<int>(std::sqrt(seen / kPlacesPerView)));
  cv::Mat1f texture;
  cv::cornerMinEigenVal(view.image, texture, kWindowSide, kGradient);
  const Eigen::Vector3d center = view.camera.Center();
  const double to_x = static_cast<double>(view.camera.width) / map_camera.width;
  const double to_y = static_cast<double>(view.camera.height) / map_camera.height;
  std::vector<Place> places;
  for (int top = 0; top < facets.rows; top += step) {
    for (int left = 0; left < facets.cols; left += step) {
      Place best;
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

// Of one pair; `facing`: the facets that face its second view.
class PairMatcher {
 public:
  PairMatcher(const FacetRays& rays, const std::vector<SmallView>& views, const CameraPair& pair,
              const std::vector<uint8_t>& facing, double least_cosine)
      : rays_(rays),
        pair_(pair),
        i_(views[pair.reference]),
        j_(views[pair.second]),
        facing_(facing),
        least_cosine_(least_cosine) {}

  std::vector<WindowMatch> Match(std::vector<Place> places, size_t most) const {
    KeepVisible(&places);
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
      return a.order < b.order || (a.order == b.order && a.facet < b.facet);
    });
    std::vector<WindowMatch> matches;
    for (const Place& place : places) {
      if (matches.size() == most) break;
      if (const std::optional<WindowMatch> match = MatchAt(place)) matches.push_back(*match);
    }
    return matches;
  }

 private:
  // Image points of j of points on the plane of a place, as functions of those of i.
  struct Warp {
    Eigen::Vector2d center;
    Eigen::Matrix2d jacobian;
  };

  void KeepVisible(std::vector<Place>* places) const {
    const Eigen::Vector3d center = j_.camera.Center();
    const auto outside = [&](const Place& place) {
      return j_.camera.Depth(place.point) <= 0 || !j_.MayHoldWindow(j_.camera.Project(place.point));
    };
    places->erase(std::remove_if(places->begin(), places->end(), outside), places->end());
    std::vector<Eigen::Vector3d> points;
    std::vector<int> facets;
    for (const Place& place : *places) {
      points.push_back(place.point);
      facets.push_back(place.facet);
    }
    std::vector<uint8_t> visible(points.size());
    rays_.CastToCenter(center, facing_, points.data(), facets.data(),
                       static_cast<int>(points.size()), visible.data());
    size_t kept = 0;
    for (size_t k = 0; k < places->size(); ++k) {
      if (visible[k] != 0) (*places)[kept++] = (*places)[k];
    }
    places->resize(kept);
  }

  std::optional<Warp> WarpAt(const Place& place) const {
    const Eigen::Vector3d normal = FaceAreaNormal(rays_.mesh(), place.facet).normalized();
    const Eigen::Vector3d center = i_.camera.Center();
    const Eigen::Vector3d to_i = center - place.point;
    const Eigen::Vector3d to_j = j_.camera.Center() - place.point;
    if (normal.dot(to_i) < kLeastCosine * to_i.norm() ||
        normal.dot(to_j) < kLeastCosine * to_j.norm() ||
        to_i.dot(to_j) < least_cosine_ * to_i.norm() * to_j.norm()) {
      return std::nullopt;
    }
    const auto through = [&](double x, double y) -> Eigen::Vector2d {
      const Eigen::Vector3d ray = i_.camera.Ray(x, y);
      return j_.camera.Project(center - normal.dot(to_i) / normal.dot(ray) * ray);
    };
    Warp warp;
    warp.center = through(place.at.x(), place.at.y());
    warp.jacobian.col(0) = through(place.at.x() + 1, place.at.y()) - warp.center;
    warp.jacobian.col(1) = through(place.at.x(), place.at.y() + 1) - warp.center;
    const double area = warp.jacobian.determinant();
    if (!(area > kSmallestWarp && area < kLargestWarp)) return std::nullopt;
    return warp;
  }

  std::optional<WindowMatch> MatchAt(const Place& place) const {
    const std::optional<Warp> warp = WarpAt(place);
    if (!warp.has_value()) return std::nullopt;
    const Eigen::Vector3d away = place.point - i_.camera.Center();
    const Eigen::Vector2d line =
        j_.camera.Project(i_.camera.Center() + 1.001 * away) - warp->center;
    const Eigen::Vector2d in_i = warp->jacobian.inverse() * line;
    if (!(in_i.norm() > 1e-9)) return std::nullopt;
    SampleGrid at_i;
    at_i.center = place.at;
    at_i.along = in_i.normalized();
    at_i.across = {-at_i.along.y(), at_i.along.x()};
    SampleGrid at_j;
    at_j.center = warp->center;
    at_j.along = warp->jacobian * at_i.along;
    at_j.across = warp->jacobian * at_i.across;
    const GridWindow window(i_.image, at_i);
    if (!window.valid() || window.contrast() < kLeastContrast) return std::nullopt;
    const std::optional<GridScores> scores = window.ScoresAround(j_.image, at_j);
    if (!scores.has_value()) return std::nullopt;
    const GridPeak peak = PeakOf(*scores);
    WindowMatch match;
    match.reference = pair_.reference;
    match.second = pair_.second;
    match.scale = i_.scale;
    match.place = i_.scale * place.at;
    match.along = peak.along;
    match.across = peak.across;
    match.row = peak.row;
    match.clear = peak.inside && peak.score > kClearScore;
    match.at_prediction = (*scores)[kMatchAcross][kMatchAlong];
    const CounterRandom random(place.order, pair_.second);
    for (int k = 0; k < kChancePlaces; ++k) {
      match.by_chance[k] = ScoreByChance(window, at_j, random, k);
    }
    return match;
  }

  float ScoreByChance(const GridWindow& window, SampleGrid at, const CounterRandom& random,
                      int place) const {
    const Eigen::Vector2d center = at.center;
    for (int k = 0; k < kChanceTries; ++k) {
      const uint64_t draw = 2 * (static_cast<uint64_t>(place) * kChanceTries + k);
      const double angle = 2 * M_PI * random.Uniform(draw);
      const double distance =
          kNearestChance + (kFarthestChance - kNearestChance) * random.Uniform(draw + 1);
      at.center = center + distance * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      if (const std::optional<float> score = window.ScoreAt(j_.image, at)) return *score;
    }
    return std::numeric_limits<float>::quiet_NaN();
  }

  const FacetRays& rays_;
  const CameraPair pair_;
  const SmallView& i_;
  const SmallView& j_;
  const std::vector<uint8_t>& facing_;  // j
  const double least_cosine_;           // of the parallax
};

// Those that are looked at.
std::vector<CameraPair> FirstPartners(const Scene& scene, const std::vector<CameraPair>& pairs) {
  std::vector<int> partners(scene.views.size(), 0);
  const auto large_enough = [&](int view) {
    const Camera& camera = scene.views[view].camera;
    return std::max(camera.width, camera.height) >= kLeastSidePx;
  };
  std::vector<CameraPair> first;
  for (const CameraPair& pair : pairs) {
    if (!large_enough(pair.reference) || !large_enough(pair.second)) continue;
    if (partners[pair.reference]++ < kPartners) first.push_back(pair);
  }
  return first;
}

}  // namespace

std::vector<WindowMatch> MatchWindows(const Scene& scene, const TriangleMesh& mesh,
                                      const std::vector<CameraPair>& pairs, int largest_side_px) {
  const std::vector<CameraPair> used = FirstPartners(scene, pairs);
  if (used.empty()) return {};
  std::vector<char> reference(scene.views.size(), 0);
  std::vector<char> any(scene.views.size(), 0);
  for (const CameraPair& pair : used) {
    reference[pair.reference] = any[pair.reference] = any[pair.second] = 1;
  }
  const FacetRays rays(mesh);
  std::vector<SmallView> views(scene.views.size());
  std::vector<std::vector<Place>> places(scene.views.size());
  ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (any[i] == 0) continue;
      views[i] = Reduce(scene.views[i], largest_side_px);
      if (reference[i] != 0) places[i] = PlacesOf(rays, views[i], i);
    }
  });
  // By second view: which facets face it is asked once.
  std::vector<std::vector<int>> pairs_of(views.size());
  for (size_t p = 0; p < used.size(); ++p) {
    pairs_of[used[p].second].push_back(static_cast<int>(p));
  }
  const size_t per_pair = std::clamp(kWindows / used.size(), kFewestPerPair, kWindowsPerPair);
  std::vector<WindowMatch> matches;
  for (const double least_cosine : {std::cos(kLargestParallax), -1.0}) {
    if (matches.size() >= kEnough) break;
    std::vector<std::vector<WindowMatch>> of_pair(used.size());
    ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
      for (int j = begin; j < end; ++j) {
        if (pairs_of[j].empty()) continue;
        const std::vector<uint8_t> facing = rays.Facing(views[j].camera.Center());
        for (const int p : pairs_of[j]) {
          const PairMatcher matcher(rays, views, used[p], facing, least_cosine);
          of_pair[p] = matcher.Match(places[used[p].reference], per_pair);
        }
      }
    });
    matches.clear();
    for (const std::vector<WindowMatch>& some : of_pair) {
      matches.insert(matches.end(), some.begin(), some.end());
    }
  }
  return matches;
}

}  // namespace burin
