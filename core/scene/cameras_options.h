// What of the cameras is refined, and how.
#pragma once

#include "core/support/choices.h"
#include "core/support/options.h"

namespace burin {

// kAuto: poses, where they are known to be better; kPoses: wherever they are not known to be worse, and so the next two:
// kPosesFocal with a factor of the focal lengths of every camera, kPosesIntrinsics with its principal point and the
// coefficients of its lens too.
enum class CameraUnknowns { kNone, kAuto, kPoses, kPosesFocal, kPosesIntrinsics };
inline Choices<CameraUnknowns> ChoicesOf(CameraUnknowns) {
  return {{CameraUnknowns::kNone, "none"},
          {CameraUnknowns::kAuto, "auto"},
          {CameraUnknowns::kPoses, "poses"},
          {CameraUnknowns::kPosesFocal, "poses_focal"},
          {CameraUnknowns::kPosesIntrinsics, "poses_intrinsics"}};
}

// kTracks: before the first level, over tracks through the mesh (core/cameras/track_step.h). kJoint: with the surface, in rounds
// of the levels (core/refine/camera_rounds.h).
enum class CameraSteps { kTracks, kJoint, kBoth };
inline Choices<CameraSteps> ChoicesOf(CameraSteps) {
  return {{CameraSteps::kTracks, "tracks"},
          {CameraSteps::kJoint, "joint"},
          {CameraSteps::kBoth, "both"}};
}

struct CamerasOptions {
  CameraUnknowns refine = CameraUnknowns::kNone;
  CameraSteps steps = CameraSteps::kBoth;
  int coarsest_joint = 1;  // level
  int finest_joint = 1;    // level
  int joint_rounds = 1;    // at most, of a level
  void Describe(OptionSet* set);

  bool ByTracks() const { return refine != CameraUnknowns::kNone && steps != CameraSteps::kJoint; }
  bool Jointly() const { return refine != CameraUnknowns::kNone && steps != CameraSteps::kTracks; }
};

}  // namespace burin
