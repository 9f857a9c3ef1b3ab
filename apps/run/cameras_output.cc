#include "apps/run/cameras_output.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "apps/run/intrinsics_output.h"
#include "core/cameras/refined_scene.h"
#include "core/scene/camera_similarity.h"
#include "core/scene/formats/colmap.h"
#include "core/support/fixed_text.h"
#include "core/support/json_file.h"
#include "core/support/listed.h"
#include "core/support/median.h"
#include "core/visibility/seen_points.h"

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

std::string NamesOf(const Scene& scene, const std::vector<int>& views) {
  std::vector<std::string> names;
  names.reserve(views.size());
  for (const int v : views) names.push_back(scene.views[v].name);
  return Listed(names);
}

// Views that no tracks hold.
std::vector<int> OutsideGroups(const TrackStep& step) {
  std::vector<char> inside(step.cameras.size(), 0);
  for (const TrackGroup& group : step.groups) {
    for (const int v : group.views) inside[v] = 1;
  }
  std::vector<int> outside;
  for (size_t v = 0; v < inside.size(); ++v) {
    if (inside[v] == 0) outside.push_back(static_cast<int>(v));
  }
  return outside;
}

// "a.jpg, b.jpg | c.jpg, d.jpg and 7 more"
std::string GroupNames(const Scene& scene, const TrackStep& step) {
  std::string text;
  for (const TrackGroup& group : step.groups) {
    text += (text.empty() ? "" : " | ") + NamesOf(scene, group.views);
  }
  return text;
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
  const bool kept = step.Kept();
  std::string line = "cameras: " + std::to_string(bundle.tracks) + " tracks through the mesh, " +
                     std::to_string(bundle.measurements) + " measurements";
  const int most = MostMoved(step);
  if (most >= 0) {
    line += "; " + std::string(kept ? "moved" : "would move") + " by " +
            Fixed(step.moved_rms_px, 2) + " px (RMS; " + scene.views[most].name + " " +
            Fixed(step.moved_px[most], 2) + "), standard deviation " +
            Fixed(step.deviation_rms_px, 2) + " px";
  }
  if (!kept) line += ": left as given, " + step.Reason();
  std::vector<std::string> lines = {line};
  if (step.groups.size() > 1) {
    lines.push_back("cameras: " + std::to_string(step.groups.size()) + " groups of views (" +
                    GroupNames(scene, step) +
                    "): no tracks join them, so how they lie to each other is only as given; the "
                    "standard deviation is within the groups");
  }
  if (kept) {
    for (const TrackGroup& group : step.groups) {
      if (group.kept) continue;
      lines.push_back(NamesOf(scene, group.views) + ": left as given, " + group.reason);
    }
    const std::vector<int> outside = OutsideGroups(step);
    if (!outside.empty()) {
      lines.push_back(NamesOf(scene, outside) +
                      ": left as given, too few windows match through the mesh");
    }
  }
  for (const int v : step.misregistered) {
    lines.push_back(scene.views[v].name + (kept ? " moved by " : " would move by ") +
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
  json["kept"] = step.Kept();
  json["reason"] = step.Kept() ? "" : step.Reason();
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
  json["groups"] = ordered_json::array();
  std::vector<ordered_json> group_of(step.cameras.size());
  for (const TrackGroup& group : step.groups) {
    for (const int v : group.views) group_of[v] = json["groups"].size();
    json["groups"].push_back(
        {{"views", group.views.size()},
         {"kept", group.kept},
         {"reason", group.reason},
         {"moved_px", RoundedOrNull(group.moved_rms_px)},
         {"deviation_px", RoundedOrNull(group.deviation_rms_px)},
         {"kept_out",
          {{"tracks", group.agreement.tracks},
           {"before", RoundedOrNull(group.agreement.before)},
           {"after", RoundedOrNull(group.agreement.after)},
           {"standard_error", RoundedOrNull(group.agreement.standard_error)}}}});
  }
  json["holds_all_views"] = step.HoldsAllViews();
  json["intrinsics"] = IntrinsicsJson(step, scene);
  json["seconds"] = step.seconds;
  json["views"] = ordered_json::array();
  for (size_t v = 0; v < step.cameras.size(); ++v) {
    json["views"].push_back({{"name", scene.views[v].name},
                             {"group", group_of[v]},
                             {"moved_px", RoundedOrNull(step.moved_px[v])},
                             {"deviation_px", RoundedOrNull(step.deviation_px[v])},
                             {"measurements", step.bundle.measured[v]}});
  }
  return json;
}

bool HoldsAllViews(const std::string& track_step_json) {
  return !track_step_json.empty() &&
         ordered_json::parse(track_step_json).at("holds_all_views").get<bool>();
}

std::string SmallLevelsText(const SmallLevels& small) {
  return "cameras: no joint rounds where images are below " + std::to_string(kLeastJointSidePx) +
         " px (level " + std::to_string(small.finest) + ": " + Fixed(small.side_px, 0) +
         " px): tracks tell cameras better there";
}

ordered_json MovedJson(const Scene& scene, const TriangleMesh& mesh,
                       const std::vector<Camera>& cameras) {
  const CameraErrors moved = MeasureCameraErrors(
      cameras, SightingsOf(CamerasOf(scene), SeenPoints(mesh, scene.views)), Similarity());
  ordered_json json = {{"px", RoundedOrNull(moved.rms_px)}, {"views", ordered_json::array()}};
  for (size_t v = 0; v < scene.views.size(); ++v) {
    json["views"].push_back(
        {{"name", scene.views[v].name}, {"px", RoundedOrNull(moved.view_px[v])}});
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
         "photographs, which burin does not write\n";
}

}  // namespace burin
