#include "core/cameras/mesh_tracks.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/cameras/sparse_tracks.h"
#include "core/evidence/match_grid.h"
#include "core/evidence/window_places.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/facet_rays.h"

namespace burin {
namespace {

constexpr int kPlaces = 30'000;       // of all views together, about
constexpr int kMostPlaces = 600;      // a view
constexpr int kFewestPlaces = 150;    // a view
constexpr int kFewestMatches = 1;     // beside the window itself
constexpr double kLeastScore = 0.7;   // ZNCC
constexpr double kLeastLead = 0.05;   // over the next best place
constexpr double kLeastCosine = 0.7;  // of the parallax: 45 degrees

// Where the other view shows a window, in pixels of its photograph.
struct PartnerMatch {
  int place;
  Eigen::Vector2d image_point;
};

std::optional<Eigen::Vector2d> MatchPlace(const TriangleMesh& mesh, const SmallView& i,
                                          const SmallView& j, const WindowPlace& place) {
  const Eigen::Vector3d normal = FaceAreaNormal(mesh, place.facet).normalized();
  const std::optional<WarpedWindow> warped =
      WarpThroughPlane(i, j, place.at, place.point, normal, kLeastCosine);
  if (!warped.has_value()) return std::nullopt;
  const GridWindow window(i.image, warped->at_i);
  if (!window.valid() || window.contrast() < kLeastContrast) return std::nullopt;
  const std::optional<GridScores> scores = window.ScoresAround(j.image, warped->at_j);
  if (!scores.has_value()) return std::nullopt;
  const GridPeak peak = PeakOf(*scores);
  if (!peak.inside || peak.score < kLeastScore || peak.score - peak.second < kLeastLead) {
    return std::nullopt;
  }
  const SampleGrid& grid = warped->at_j;
  return j.InPhotograph(grid.center + peak.along * grid.along + peak.across * grid.across);
}

}  // namespace

MeshTracks FindMeshTracks(const Scene& scene, const TriangleMesh& mesh,
                          const std::vector<CameraPair>& pairs, int largest_side_px) {
  const std::vector<CameraPair> used = FirstPartners(scene, pairs, kMatchingPartners);
  const auto view_count = static_cast<int>(scene.views.size());
  MeshTracks found;
  found.pixel.assign(view_count, 1);
  found.groups.of_view.assign(view_count, -1);
  if (used.empty()) return found;
  std::vector<std::vector<int>> pairs_of(view_count);  // by second view
  std::vector<char> any(view_count, 0);
  for (size_t p = 0; p < used.size(); ++p) {
    pairs_of[used[p].second].push_back(static_cast<int>(p));
    any[used[p].reference] = any[used[p].second] = 1;
  }
  const int count = std::clamp(kPlaces / view_count, kFewestPlaces, kMostPlaces);
  const FacetRays rays(mesh);
  std::vector<SmallView> views(view_count);
  std::vector<std::vector<WindowPlace>> places(view_count);
  ParallelFor(view_count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (any[i] == 0) continue;
      views[i] = Reduce(scene.views[i], largest_side_px);
      found.pixel[i] = views[i].pixel.x();
      places[i] = PlacesOf(mesh, views[i], i, count);
    }
  });
  std::vector<std::vector<PartnerMatch>> matches(used.size());
  ParallelFor(view_count, 1, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      if (pairs_of[j].empty()) continue;
      const std::vector<uint8_t> facing = FacingFacets(mesh, views[j].camera.Center());
      for (const int p : pairs_of[j]) {
        const int i = used[p].reference;
        for (const int k : PlacesSeenFrom(rays, views[j], facing, places[i])) {
          const std::optional<Eigen::Vector2d> at =
              MatchPlace(mesh, views[i], views[j], places[i][k]);
          if (at.has_value()) matches[p].push_back({k, *at});
        }
      }
    }
  });
  std::vector<std::vector<std::vector<Measurement>>> of_place(view_count);
  for (int i = 0; i < view_count; ++i) of_place[i].resize(places[i].size());
  for (size_t p = 0; p < used.size(); ++p) {
    for (const PartnerMatch& match : matches[p]) {
      of_place[used[p].reference][match.place].push_back({match.image_point, used[p].second});
    }
  }
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < view_count; ++i) {
    for (size_t k = 0; k < places[i].size(); ++k) {
      if (static_cast<int>(of_place[i][k].size()) < kFewestMatches) continue;
      points.push_back(places[i][k].point);
      found.tracks.BeginPoint();
      found.tracks.Add({views[i].InPhotograph(places[i][k].at), i});
      for (const Measurement& measured : of_place[i][k]) found.tracks.Add(measured);
    }
  }
  const size_t windows = points.size();
  AppendSparseTracks(scene, &points, &found.tracks);
  std::vector<int> kept;
  found.groups = GroupViews(view_count, &found.tracks, &kept);
  for (const int p : kept) found.points.push_back(points[p]);
  found.windows =
      std::lower_bound(kept.begin(), kept.end(), static_cast<int>(windows)) - kept.begin();
  return found;
}

}  // namespace burin
