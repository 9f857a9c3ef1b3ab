// What of the cameras is refined.
#pragma once

#include "core/support/choices.h"
#include "core/support/options.h"

namespace burin {

enum class CameraUnknowns { kNone, kPoses };
inline Choices<CameraUnknowns> ChoicesOf(CameraUnknowns) {
  return {{CameraUnknowns::kNone, "none"}, {CameraUnknowns::kPoses, "poses"}};
}

struct CamerasOptions {
  CameraUnknowns refine = CameraUnknowns::kNone;
  void Describe(OptionSet* set);
};

}  // namespace burin
