// What a run says of the cameras that it refined, and the model that it writes.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/cameras/track_step.h"
#include "core/mesh/mesh.h"
#include "core/refine/camera_rounds.h"
#include "core/scene/scene.h"

namespace burin {

// Lines for the log.
std::vector<std::string> TrackStepText(const TrackStep& step, const Scene& scene);

// `cameras.tracks` of summary.json.
nlohmann::ordered_json TrackStepJson(const TrackStep& step, const Scene& scene);

// TrackStep::HoldsAllViews of the step that TrackStepJson() told of, as text; empty text: false.
bool HoldsAllViews(const std::string& track_step_json);

// A line for the log.
std::string SmallLevelsText(const SmallLevels& small);

// How far cameras moved from the scene's, by view: RMS of what the mesh's image moved, pixels.
nlohmann::ordered_json MovedJson(const Scene& scene, const TriangleMesh& mesh,
                                 const std::vector<Camera>& cameras);

// Medians over all measurements of the scene's sparse points, pixels: as they are, and with the points triangulated anew
// by other cameras in `seen`: the scene, or TrackStep::seen. Null where the scene has no measurements.
nlohmann::ordered_json SparsePointsJson(const Scene& scene, const Scene& seen,
                                        const std::vector<Camera>& cameras);

// The scene with these cameras as a COLMAP model, in `folder`/sparse (core/scene/formats/colmap.h:
// WritePhotographedModel); sparse points that have measurements are triangulated anew. Returns what is to be said about it; empty: nothing.
std::string WriteCameras(const Scene& scene, const std::vector<Camera>& cameras,
                         const std::filesystem::path& folder);

}  // namespace burin
