#include "core/cameras/track_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/cameras/lens_change.h"
#include "core/cameras/pose_uncertainty.h"
#include "core/scene/camera_similarity.h"
#include "core/support/median.h"
#include "core/support/stopwatch.h"
#include "core/visibility/seen_points.h"

namespace burin {
namespace {

// Passes: the first searches small images, which reach further, the others large ones, which measure finer. After two they
// go on while the last moved by more than this, RMS over the views that see the surface, in pixels.
constexpr int kFewestPasses = 2;
constexpr int kMostPasses = 5;
constexpr double kSettledPx = 0.5;

constexpr double kFarOff =
    4;  // a view is misregistered that moves by so many medians of the others,
constexpr double kFarPx = 4;  // and by so many pixels

double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  int count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value * value;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::quiet_NaN();
}

double RootMeanSquare(const std::vector<double>& values, const std::vector<int>& views) {
  std::vector<double> of_views;
  of_views.reserve(views.size());
  for (const int v : views) of_views.push_back(values[v]);
  return RootMeanSquare(of_views);
}

// Moves the group's world to where the surface's image is nearest to that of the cameras given, and
// measures what is left. Views that are far off others do not hold it.
bool HoldFrame(const std::vector<Camera>& given,
               const std::vector<std::vector<Sighting>>& sightings, const TrackGroup& group,
               TrackStep* step, std::string* reason) {
  std::vector<std::vector<Sighting>> of_group(sightings.size());
  for (const int v : group.views) of_group[v] = sightings[v];
  std::vector<std::vector<Sighting>> holding = of_group;
  std::vector<Camera>& cameras = step->bundle.cameras;
  for (;;) {
    CameraSimilarity fit;
    if (!FitCameraSimilarity(given, cameras, holding, &fit, reason)) return false;
    const CameraErrors errors = MeasureCameraErrors(cameras, of_group, fit.second_from_first);
    std::vector<double> of_holding;
    int worst = -1;
    for (const int v : group.views) {
      if (holding[v].empty() || !std::isfinite(errors.view_px[v])) continue;
      of_holding.push_back(errors.view_px[v]);
      if (worst < 0 || errors.view_px[v] > errors.view_px[worst]) worst = v;
    }
    const double usual = Median(of_holding);
    if (of_holding.size() > 3 && errors.view_px[worst] > std::max(kFarPx, kFarOff * usual)) {
      holding[worst].clear();
      step->misregistered.push_back(worst);
      continue;
    }
    for (const int v : group.views) {
      cameras[v] = Moved(cameras[v], fit.second_from_first.Inverse());
      step->moved_px[v] = errors.view_px[v];
    }
    return true;
  }
}

std::vector<TrackGroup> LargestFirst(const ViewGroups& groups) {
  std::vector<TrackGroup> sorted(groups.count);
  for (int g = 0; g < groups.count; ++g) sorted[g].views = groups.ViewsOf(g);
  std::stable_sort(sorted.begin(), sorted.end(), [](const TrackGroup& a, const TrackGroup& b) {
    return a.views.size() > b.views.size();
  });
  return sorted;
}

// Every group's world to the frame of the cameras given; views in none have the poses given.
void HoldFrames(const Scene& scene, const std::vector<Camera>& given,
                const std::vector<std::vector<Eigen::Vector3d>>& surface, TrackStep* step) {
  std::vector<Camera>& cameras = step->bundle.cameras;
  const std::vector<std::vector<Sighting>> sightings =
      SightingsThrough(scene, surface, cameras, step->bundle.lenses);
  step->misregistered.clear();
  step->moved_px.assign(given.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<char> in_frame(given.size(), 0);
  for (TrackGroup& group : step->groups) {
    const bool held = HoldFrame(given, sightings, group, step, &group.reason);
    for (const int v : group.views) in_frame[v] = held ? 1 : 0;
  }
  for (size_t v = 0; v < given.size(); ++v) {
    if (in_frame[v] != 0) continue;
    cameras[v].rotation = given[v].rotation;
    cameras[v].translation = given[v].translation;
  }
  std::sort(step->misregistered.begin(), step->misregistered.end());
}

// One that is left as given keeps the others.
void KeepAllOrNone(std::vector<TrackGroup>* groups) {
  const auto left = std::find_if(groups->begin(), groups->end(),
                                 [](const TrackGroup& group) { return !group.kept; });
  if (left == groups->end()) return;
  const std::string reason = left->reason;
  for (TrackGroup& group : *groups) {
    group.kept = false;
    if (group.reason.empty()) group.reason = reason;
  }
}

// Median over the group's views, of the longer side of their pictures.
double StepShare(const std::vector<Camera>& cameras, const std::vector<double>& moved_px,
                 const std::vector<int>& views) {
  std::vector<double> shares;
  for (const int v : views) {
    if (std::isfinite(moved_px[v])) {
      shares.push_back(moved_px[v] / std::max(cameras[v].width, cameras[v].height));
    }
  }
  return Median(shares);
}

// Why the group's cameras are left as given; empty where the new ones are kept.
std::string ReasonAgainst(const TrackGroup& group, TrackRule rule, double step_share) {
  if (!group.reason.empty()) return group.reason;
  if (!group.agreement.Known()) return "too few windows match through the mesh";
  if (rule == TrackRule::kNotWorse) {
    return group.agreement.Worse() ? "tracks that were kept out agree less" : "";
  }
  if (!group.agreement.Better()) return "tracks that were kept out agree no better";
  if (!std::isfinite(group.deviation_rms_px)) return "its uncertainty is not known";
  if (step_share > kMostStepShare) {
    return "most views would move by more than 2 % of the picture: the cameras are wrong, not "
           "uncertain";
  }
  const double least = std::max(kBeyond * group.deviation_rms_px, kLeastStepPx);
  return group.moved_rms_px > least ? "" : "the step is within its uncertainty";
}

}  // namespace

bool TrackStep::Kept() const {
  return std::any_of(groups.begin(), groups.end(),
                     [](const TrackGroup& group) { return group.kept; });
}

void TrackStep::HandBack(const Scene& given, const std::string& reason) {
  for (TrackGroup& group : groups) {
    if (group.kept) group.reason = reason;
    group.kept = false;
  }
  cameras = CamerasOf(given);
  seen.reset();
}

bool TrackStep::HoldsAllViews() const {
  return groups.size() == 1 && groups[0].kept && groups[0].views.size() == cameras.size();
}

std::string TrackStep::Reason() const {
  return groups.empty() ? "too few windows match through the mesh" : groups.front().reason;
}

TrackStep RefineByTracks(const Scene& scene, const TriangleMesh& mesh,
                         const std::vector<CameraPair>& pairs, TrackRule rule,
                         IntrinsicUnknowns unknowns) {
  const Stopwatch watch;
  TrackStep step;
  const std::vector<Camera> given = CamerasOf(scene);
  step.cameras = given;
  const std::vector<std::vector<Eigen::Vector3d>> surface = SeenPoints(mesh, scene.views);
  const std::vector<double> unknown(given.size(), std::numeric_limits<double>::quiet_NaN());
  step.moved_px = step.deviation_px = unknown;
  std::vector<Lens> lenses;
  for (const View& view : scene.views) lenses.push_back(view.origin.lens);
  Scene photographs = scene;
  Scene now = scene;
  MeshTracks tracks;
  MeshTracks tracks_given;  // in the images given
  double last_px = 0;       // what the last pass moved
  for (int pass = 0; pass < kFewestPasses || (last_px > kSettledPx && pass < kMostPasses); ++pass) {
    const std::vector<Camera> before = CamerasOf(now);
    tracks = FindMeshTracks(now, mesh, pairs, pass == 0 ? kMatchSidePx : 2 * kMatchSidePx);
    step.bundle = AdjustBundle(now, tracks, unknowns);
    const Bundle& bundle = step.bundle;
    tracks.sparse_scale = bundle.sparse_scale;
    step.groups = LargestFirst(tracks.groups);
    if (FoldsEarlier(scene, bundle.cameras, bundle.lenses)) {
      step.moved_px = unknown;
      for (TrackGroup& group : step.groups)
        group.reason = "a lens would fold back inside its picture";
      step.seconds = watch.Seconds();
      return step;
    }
    tracks_given = SeenThrough(tracks, now, given, bundle.lenses.empty() ? bundle.lenses : lenses);
    tracks = SeenThrough(tracks, now, bundle.cameras, bundle.lenses);
    HoldFrames(scene, given, surface, &step);
    photographs = WithIntrinsics(scene, bundle.cameras, bundle.lenses);
    now = WithCameras(photographs, bundle.cameras);
    last_px = MeasureCameraErrors(bundle.cameras, SightingsOf(before, surface), {}).rms_px;
  }
  step.deviation_px =
      PoseDeviations(step.bundle.cameras, tracks, step.bundle.sigma, kFinestLossPx, surface);
  step.moved_rms_px = RootMeanSquare(step.moved_px);
  step.deviation_rms_px = RootMeanSquare(step.deviation_px);
  for (TrackGroup& group : step.groups) {
    const int number = tracks.groups.of_view[group.views.front()];
    group.agreement = CompareKeptOut(number, tracks_given, given, tracks, step.bundle.cameras);
    group.moved_rms_px = RootMeanSquare(step.moved_px, group.views);
    group.deviation_rms_px = RootMeanSquare(step.deviation_px, group.views);
    group.reason = ReasonAgainst(group, rule, StepShare(given, step.moved_px, group.views));
    group.kept = group.reason.empty();
  }
  if (!step.bundle.lenses.empty()) KeepAllOrNone(&step.groups);
  for (const TrackGroup& group : step.groups) {
    for (size_t k = 0; group.kept && k < group.views.size(); ++k) {
      step.cameras[group.views[k]] = step.bundle.cameras[group.views[k]];
    }
  }
  if (step.Kept() && !step.bundle.lenses.empty()) {
    step.cameras = step.bundle.cameras;  // intrinsics of views in no group too
    step.seen = std::make_shared<const Scene>(std::move(photographs));
  }
  step.seconds = watch.Seconds();
  return step;
}

}  // namespace burin
