// What a run says of the intrinsics that it refined.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/cameras/track_step.h"
#include "core/scene/scene.h"

namespace burin {

// How the intrinsics of one camera changed between the scene and step.bundle.
struct IntrinsicsChange {
  double focal_px = 0;  // of the focal length, pixels at the picture's edge: half the longer side
  double corner_px =
      0;  // farthest move of what the photograph showed in its corners, as far as the lens does not fold back
};

// Of every camera of step.bundle.shared.
std::vector<IntrinsicsChange> IntrinsicsChanges(const TrackStep& step, const Scene& scene);

// Lines for the log: one of all cameras or one of each, and one of each whose intrinsics changed far more than the
// others'. None where no intrinsics were to be refined, or those of more than four cameras and none was.
std::vector<std::string> IntrinsicsText(const TrackStep& step, const Scene& scene);

// `cameras.tracks.intrinsics` of summary.json: an item a camera.
nlohmann::ordered_json IntrinsicsJson(const TrackStep& step, const Scene& scene);

}  // namespace burin
