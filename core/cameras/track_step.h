// The first step of refining cameras: tracks through the mesh (core/cameras/mesh_tracks.h) and their bundle
// adjustment (core/cameras/bundle.h), twice: the second time through cameras that are nearly right, in images of
// twice the size; and up to thrice more while they still move by half a pixel. It takes pixels of error away. Of errors
// that the rough mesh hides it knows nothing.
//
// Each group of views that tracks hold together (core/cameras/view_groups.h) is put where the surface's image moves
// least: nothing says how groups lie to each other but the cameras given. Its cameras are kept where they are better than
// those: tracks that were kept out agree more by two standard errors, and the step is beyond its own
// uncertainty (core/cameras/pose_uncertainty.h),
//
//   rms_v step_v  >  max(kBeyond rms_v sd_v, kLeastStepPx)       pixels of the surface
//
// and at most half of the views move by more than kMostStepShare of their longer side: cameras that are so far off together are wrong,
// and poses that make the best of them would hide it.
// kLeastStepPx is for what the deviations do not know: windows on a rough mesh are warped a little wrong, all in
// the same way.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/cameras/bundle.h"
#include "core/mesh/mesh.h"
#include "core/scene/cameras_options.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

constexpr double kBeyond = 2;
constexpr double kLeastStepPx = 0.1;
constexpr double kMostStepShare = 0.02;

// Which cameras are kept: new ones that are known to be better, as above, or those that are not known to be worse.
enum class TrackRule { kBetter, kNotWorse };

// Views that tracks hold together.
struct TrackGroup {
  std::vector<int> views;
  bool kept = false;         // the new cameras
  std::string reason;        // why not
  TrackAgreement agreement;  // of tracks kept out, between the cameras given and the new ones
  double moved_rms_px = 0;
  double deviation_rms_px = 0;
};

struct TrackStep {
  std::vector<Camera>
      cameras;  // of the scene's views, in its frame; those given where they are kept
  // The scene given with the intrinsics of `cameras`, its photographs undistorted again where these have a lens
  // (core/cameras/lens_change.h); null: as given.
  std::shared_ptr<const Scene> seen;
  Bundle bundle;                   // the last round's; its cameras are the new ones in any case
  std::vector<TrackGroup> groups;  // of the last round, larger ones first
  std::vector<double>
      moved_px;  // of every view: RMS over the surface that it sees; NaN where it sees none or
                 // is in no group
  std::vector<double> deviation_px;  // PoseDeviations()
  std::vector<int>
      misregistered;        // moved far more than others of their group: they do not hold its frame
  double moved_rms_px = 0;  // of the views of groups
  double deviation_rms_px = 0;
  double seconds = 0;

  // New cameras of any group.
  bool Kept() const;
  // Keeps none: the cameras are those of `given`, the scene, for this reason.
  void HandBack(const Scene& given, const std::string& reason);
  // One group of all views, and its new cameras.
  bool HoldsAllViews() const;
  // Why not, of the largest group.
  std::string Reason() const;

  const Scene& SeenOr(const Scene& scene) const { return seen != nullptr ? *seen : scene; }
};

inline TrackRule RuleOf(CameraUnknowns refine) {
  return refine == CameraUnknowns::kAuto ? TrackRule::kBetter : TrackRule::kNotWorse;
}

// Of `pairs`, of each view the first kMatchingPartners. Intrinsics are shared by views of several groups: with `unknowns` of
// them all groups are kept or none. The same for any number of threads. Throws InputError where a photograph cannot be read again.
TrackStep RefineByTracks(const Scene& scene, const TriangleMesh& mesh,
                         const std::vector<CameraPair>& pairs, TrackRule rule,
                         IntrinsicUnknowns unknowns = IntrinsicUnknowns::kNone);

}  // namespace burin
