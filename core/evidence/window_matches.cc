#include "core/evidence/window_matches.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>

#include "core/evidence/match_grid.h"
#include "core/evidence/window_places.h"
#include "core/support/counter_random.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/facet_rays.h"

namespace burin {
namespace {

constexpr size_t kWindowsPerPair = 40;  // looked at, in scenes of up to 150 pairs;
constexpr size_t kFewestPerPair = 12;   // in large ones at least so many
constexpr size_t kWindows = 6000;       // and together about so many
constexpr int kPlacesPerView = 320;     // to choose them from
constexpr double kLargestParallax = 35 * M_PI / 180;
constexpr size_t kEnough = 30;  // windows under that parallax, or others are looked at too
constexpr double kClearScore = 0.6;
constexpr double kNearestChance = 15;
constexpr double kFarthestChance = 60;
constexpr int kChanceTries = 30;

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

  std::vector<WindowMatch> Match(const std::vector<WindowPlace>& all, size_t most) const {
    std::vector<WindowPlace> places;
    for (const int k : PlacesSeenFrom(rays_, j_, facing_, all)) places.push_back(all[k]);
    std::sort(places.begin(), places.end(), [](const WindowPlace& a, const WindowPlace& b) {
      return a.order < b.order || (a.order == b.order && a.facet < b.facet);
    });
    std::vector<WindowMatch> matches;
    for (const WindowPlace& place : places) {
      if (matches.size() == most) break;
      if (const std::optional<WindowMatch> match = MatchAt(place)) matches.push_back(*match);
    }
    return matches;
  }

 private:
  std::optional<WindowMatch> MatchAt(const WindowPlace& place) const {
    const Eigen::Vector3d normal = FaceAreaNormal(rays_.mesh(), place.facet).normalized();
    const std::optional<WarpedWindow> warped =
        WarpThroughPlane(i_, j_, place.at, place.point, normal, least_cosine_);
    if (!warped.has_value()) return std::nullopt;
    const SampleGrid& at_i = warped->at_i;
    const SampleGrid& at_j = warped->at_j;
    const GridWindow window(i_.image, at_i);
    if (!window.valid() || window.contrast() < kLeastContrast) return std::nullopt;
    const std::optional<GridScores> scores = window.ScoresAround(j_.image, at_j);
    if (!scores.has_value()) return std::nullopt;
    const GridPeak peak = PeakOf(*scores);
    WindowMatch match;
    match.reference = pair_.reference;
    match.second = pair_.second;
    match.scale = i_.pixel.x();
    match.place = i_.pixel.x() * place.at;
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
  std::vector<std::vector<WindowPlace>> places(scene.views.size());
  ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (any[i] == 0) continue;
      views[i] = Reduce(scene.views[i], largest_side_px);
      if (reference[i] != 0) places[i] = PlacesOf(mesh, views[i], i, kPlacesPerView);
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
        const std::vector<uint8_t> facing = FacingFacets(mesh, views[j].camera.Center());
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
