#include "core/cameras/track_step.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>

#include "core/cameras/lens_change.h"
#include "core/cameras/pose_uncertainty.h"
#include "core/scene/camera_similarity.h"
#include "core/support/median.h"
#include "core/support/stopwatch.h"
#include "core/visibility/seen_points.h"

namespace burin {
namespace {

// Of the images searched: small ones reach further, and large ones measure finer.
constexpr int kSidePx[] = {kMatchSidePx, 2 * kMatchSidePx};

constexpr double kFarOff =
    4;  // a view is misregistered that moves by so many medians of the others,
constexpr double kFarPx = 8;  // and by so many pixels

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

// The adjustment left the view where it was.
bool IsHeld(const Bundle& bundle, size_t view) {
  return bundle.measured[view] < kFewestMeasurements;
}

// Moves the world of step->bundle.cameras to where the surface's image is nearest to that of the cameras given, and
// measures what is left. Views that are far off others do not hold it.
bool HoldFrame(const Scene& scene, const std::vector<Camera>& given,
               const std::vector<std::vector<Eigen::Vector3d>>& surface, TrackStep* step) {
  const std::vector<std::vector<Sighting>> sightings =
      SightingsThrough(scene, surface, step->bundle.cameras, step->bundle.lenses);
  std::vector<std::vector<Sighting>> holding = sightings;
  std::vector<Camera>& cameras = step->bundle.cameras;
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (IsHeld(step->bundle, v)) holding[v].clear();
  }
  step->misregistered.clear();
  for (;;) {
    CameraSimilarity fit;
    if (!FitCameraSimilarity(given, cameras, holding, &fit, &step->reason)) return false;
    const CameraErrors errors = MeasureCameraErrors(cameras, sightings, fit.second_from_first);
    std::vector<double> of_holding;
    int worst = -1;
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (holding[v].empty() || !std::isfinite(errors.view_px[v])) continue;
      of_holding.push_back(errors.view_px[v]);
      if (worst < 0 || errors.view_px[v] > errors.view_px[worst]) worst = static_cast<int>(v);
    }
    const double usual = Median(of_holding);
    if (of_holding.size() > 3 && errors.view_px[worst] > std::max(kFarPx, kFarOff * usual)) {
      holding[worst].clear();
      step->misregistered.push_back(worst);
      continue;
    }
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (IsHeld(step->bundle, v)) continue;
      cameras[v] = Moved(cameras[v], fit.second_from_first.Inverse());
    }
    step->moved_px = errors.view_px;
    step->moved_rms_px = errors.rms_px;
    return true;
  }
}

}  // namespace

TrackStep RefineByTracks(const Scene& scene, const TriangleMesh& mesh,
                         const std::vector<CameraPair>& pairs, TrackRule rule,
                         IntrinsicUnknowns unknowns) {
  const Stopwatch watch;
  TrackStep step;
  const std::vector<Camera> given = CamerasOf(scene);
  step.cameras = given;
  const std::vector<std::vector<Eigen::Vector3d>> surface = SeenPoints(mesh, scene.views);
  std::vector<Lens> lenses;
  for (const View& view : scene.views) lenses.push_back(view.origin.lens);
  Scene photographs = scene;
  Scene now = scene;
  MeshTracks tracks;
  MeshTracks tracks_given;  // in the images given
  for (size_t round = 0; round < std::size(kSidePx); ++round) {
    tracks = FindMeshTracks(now, mesh, pairs, kSidePx[round]);
    step.bundle = AdjustBundle(now, tracks, unknowns);
    const Bundle& bundle = step.bundle;
    if (FoldsEarlier(scene, bundle.cameras, bundle.lenses)) {
      step.reason = "a lens would fold back inside its picture";
      return step;
    }
    tracks_given = SeenThrough(tracks, now, given, bundle.lenses.empty() ? bundle.lenses : lenses);
    tracks = SeenThrough(tracks, now, bundle.cameras, bundle.lenses);
    if (bundle.tracks == 0) break;
    if (!HoldFrame(scene, given, surface, &step)) return step;
    photographs = WithIntrinsics(scene, bundle.cameras, bundle.lenses);
    now = WithCameras(photographs, bundle.cameras);
  }
  step.deviation_px =
      PoseDeviations(step.bundle.cameras, tracks, step.bundle.sigma, kFinestLossPx, surface);
  step.deviation_rms_px = RootMeanSquare(step.deviation_px);
  step.agreement = CompareKeptOut(tracks_given, given, tracks, step.bundle.cameras);
  const bool better = rule == TrackRule::kBetter;
  if (!step.agreement.Known()) {
    step.reason = "too few windows match through the mesh";
  } else if (better && !step.agreement.Better()) {
    step.reason = "tracks that were kept out agree no better";
  } else if (!better && step.agreement.Worse()) {
    step.reason = "tracks that were kept out agree less";
  } else if (better && !std::isfinite(step.deviation_rms_px)) {
    step.reason = "its uncertainty is not known";
  } else if (better &&
             !(step.moved_rms_px > std::max(kBeyond * step.deviation_rms_px, kLeastStepPx))) {
    step.reason = "the step is within its uncertainty";
  } else {
    step.kept = true;
    step.cameras = step.bundle.cameras;
    if (!step.bundle.lenses.empty()) {
      step.seen = std::make_shared<const Scene>(std::move(photographs));
    }
  }
  step.seconds = watch.Seconds();
  return step;
}

}  // namespace burin
