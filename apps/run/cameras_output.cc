#include "apps/run/cameras_output.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "apps/run/intrinsics_output.h"
#include "core/cameras/refined_scene.h"
#include "core/scene/formats/colmap.h"
#include "core/support/fixed_text.h"
#include "core/support/json_file.h"
#include "core/support/median.h"

namespace burin {
namespace {

using nlohmann::ordered_json;

// The view that moved most; -1 when none has.
int MostMoved(const TrackStep& step) {
  int most = -1;
  for (size_t v = 0; v < step.moved_px.size(); ++v) {
    if (!(step.moved_px[v] > 0)) continue;
    if (most < 0 || step.moved_px[v] > step.moved_px[most]) most = static_cast<int>(v);
  }
  return most;
}

double MedianError(const Scene& scene) {
  std::vector<double> errors;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    const Eigen::Vector3d& point = scene.points[p].position;
    for (const Measurement& measured : scene.tracks.Of(p)) {
      const Camera& camera = scene.views[measured.view].camera;
      if (camera.Depth(point) <= 0) continue;
      errors.push_back((camera.Project(point) - measured.image_point).norm());
    }
  }
  return Median(errors);
}

}  // namespace

std::vector<std::string> TrackStepText(const TrackStep& step, const Scene& scene) {
  const Bundle& bundle = step.bundle;
  std::string line = "cameras: " + std::to_string(bundle.tracks) + " tracks through the mesh, " +
                     std::to_string(bundle.measurements) + " measurements";
  const int most = MostMoved(step);
  if (most >= 0) {
    line += "; " + std::string(step.kept ? "moved" : "would move") + " by " +
            Fixed(step.moved_rms_px, 2) + " px (RMS; " + scene.views[most].name + " " +
            Fixed(step.moved_px[most], 2) + "), standard deviation " +
            Fixed(step.deviation_rms_px, 2) + " px";
  }
  if (!step.kept) line += ": left as given, " + step.reason;
  std::vector<std::string> lines = {line};
  for (const int v : step.misregistered) {
    lines.push_back(scene.views[v].name + (step.kept ? " moved by " : " would move by ") +
                    Fixed(step.moved_px[v], 0) +
                    " px, far more than the others: it was likely misregistered");
  }
  for (std::string& of_intrinsics : IntrinsicsText(step, scene)) {
    lines.push_back(std::move(of_intrinsics));
  }
  return lines;
}

ordered_json TrackStepJson(const TrackStep& step, const Scene& scene) {
  ordered_json json;
  json["kept"] = step.kept;
  json["reason"] = step.reason;
  json["moved_px"] = RoundedOrNull(step.moved_rms_px);
  json["deviation_px"] = RoundedOrNull(step.deviation_rms_px);
  const int most = MostMoved(step);
  json["most_moved"] = most >= 0 ? ordered_json(scene.views[most].name) : ordered_json();
  json["misregistered"] = ordered_json::array();
  for (const int v : step.misregistered) json["misregistered"].push_back(scene.views[v].name);
  json["tracks"] = step.bundle.tracks;
  json["measurements"] = step.bundle.measurements;
  json["measurement_px"] = {{"before", RoundedOrNull(step.bundle.median_before)},
                            {"after", RoundedOrNull(step.bundle.median_after)}};
  json["kept_out"] = {{"tracks", step.agreement.tracks},
                      {"before", RoundedOrNull(step.agreement.before)},
                      {"after", RoundedOrNull(step.agreement.after)},
                      {"standard_error", RoundedOrNull(step.agreement.standard_error)}};
  json["intrinsics"] = IntrinsicsJson(step, scene);
  json["seconds"] = step.seconds;
  json["views"] = ordered_json::array();
  for (size_t v = 0; v < step.moved_px.size(); ++v) {
    const bool measured = v < step.bundle.measured.size();
    json["views"].push_back(
        {{"name", scene.views[v].name},
         {"moved_px", RoundedOrNull(step.moved_px[v])},
         {"deviation_px",
          v < step.deviation_px.size() ? RoundedOrNull(step.deviation_px[v]) : ordered_json()},
         {"measurements", measured ? step.bundle.measured[v] : 0}});
  }
  return json;
}

ordered_json SparsePointsJson(const Scene& scene, const Scene& seen,
                              const std::vector<Camera>& cameras) {
  if (scene.tracks.IsEmpty()) return nullptr;
  return {{"before_px", RoundedOrNull(MedianError(scene))},
          {"after_px", RoundedOrNull(MedianError(WithRefinedCameras(seen, cameras)))}};
}

std::string WriteCameras(const Scene& scene, const std::vector<Camera>& cameras,
                         const std::filesystem::path& folder) {
  if (WritePhotographedModel(WithRefinedCameras(scene, cameras), folder)) return "";
  return (folder / "sparse").string() +
         ": COLMAP has no model for a lens of the scene; the cameras are of undistorted "
         "photographs\n";
}

}  // namespace burin
