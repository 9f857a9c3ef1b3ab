// What of the cameras is refined, and how.
#pragma once

#include "core/support/choices.h"
#include "core/support/options.h"

namespace burin {

enum class CameraUnknowns { kNone, kPoses };
inline Choices<CameraUnknowns> ChoicesOf(CameraUnknowns) {
  return {{CameraUnknowns::kNone, "none"}, {CameraUnknowns::kPoses, "poses"}};
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
  CameraSteps steps = CameraSteps::kTracks;
  int coarsest_joint = 2;  // level
  void Describe(OptionSet* set);

  bool ByTracks() const { return refine != CameraUnknowns::kNone && steps != CameraSteps::kJoint; }
  bool Jointly() const { return refine != CameraUnknowns::kNone && steps != CameraSteps::kTracks; }
};

}  // namespace burin
