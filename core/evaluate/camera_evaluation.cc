#include "core/evaluate/camera_evaluation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/scene/camera_similarity.h"
#include "core/scene/lens_points.h"
#include "core/support/error.h"
#include "core/visibility/seen_points.h"

namespace burin {
namespace {

constexpr double kSameShape = 0.01;  // by which width / height may differ

struct CommonViews {
  std::vector<View> scene;
  std::vector<View> truth;  // at the size of the scene's images
};

View AtSizeOf(const View& scene_view, View truth_view) {
  const Camera& to = scene_view.camera;
  Camera& camera = truth_view.camera;
  const double stretch = (static_cast<double>(camera.width) * to.height) /
                         (static_cast<double>(camera.height) * to.width);
  if (std::abs(stretch - 1) > kSameShape) {
    throw InputError("cameras: image " + scene_view.name + " is " + std::to_string(to.width) +
                     " x " + std::to_string(to.height) + " in the scene, " +
                     std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                     " in the true model: not the same shape");
  }
  if (camera.width != to.width || camera.height != to.height) {
    camera = camera.Resized(to.width, to.height);
  }
  return truth_view;
}

// Views of a scene are in ascending order of name.
CommonViews Common(const Scene& scene, const Scene& truth, CameraEvaluation* evaluation) {
  CommonViews common;
  size_t t = 0;
  for (const View& view : scene.views) {
    while (t < truth.views.size() && truth.views[t].name < view.name) {
      evaluation->only_in_truth.push_back(truth.views[t++].name);
    }
    if (t == truth.views.size() || truth.views[t].name != view.name) {
      evaluation->only_in_scene.push_back(view.name);
      continue;
    }
    common.scene.push_back(view);
    common.truth.push_back(AtSizeOf(view, truth.views[t++]));
  }
  for (; t < truth.views.size(); ++t) evaluation->only_in_truth.push_back(truth.views[t].name);
  if (common.scene.size() < 2) {
    throw InputError("cameras: scene and true model have " + std::to_string(common.scene.size()) +
                     " image names in common, at least 2 needed; the first are " +
                     scene.views[0].name + " and " + truth.views[0].name);
  }
  return common;
}

std::vector<Camera> CamerasOf(const std::vector<View>& views) {
  std::vector<Camera> cameras;
  cameras.reserve(views.size());
  for (const View& view : views) cameras.push_back(view.camera);
  return cameras;
}

// As the first cameras and lenses photograph the points, undistorted by the lenses of the second ones.
std::vector<std::vector<Sighting>> Photographed(
    const std::vector<View>& first, const std::vector<View>& second,
    const std::vector<std::vector<Eigen::Vector3d>>& points) {
  std::vector<std::vector<Sighting>> sightings = SightingsOf(CamerasOf(first), points);
  for (size_t v = 0; v < sightings.size(); ++v) {
    const PointUndistortion undistortion(second[v].camera, second[v].origin.lens);
    std::vector<Sighting> kept;
    for (Sighting seen : sightings[v]) {
      const std::optional<Eigen::Vector2d> pixel =
          undistortion(PhotographedAt(first[v].camera, first[v].origin.lens, seen.pixel));
      if (!pixel) continue;
      seen.pixel = *pixel;
      kept.push_back(seen);
    }
    sightings[v] = std::move(kept);
  }
  return sightings;
}

}  // namespace

CameraEvaluation EvaluateCameras(const Scene& scene, const Scene& truth,
                                 const TriangleMesh& surface, bool on_truth) {
  CameraEvaluation evaluation;
  evaluation.on_truth = on_truth;
  const CommonViews common = Common(scene, truth, &evaluation);
  const std::vector<View>& first = on_truth ? common.truth : common.scene;
  const std::vector<View>& second = on_truth ? common.scene : common.truth;
  const std::vector<std::vector<Sighting>> sightings =
      Photographed(first, second, SeenPoints(surface, first));
  CameraSimilarity fit;
  std::string error;
  if (!FitCameraSimilarity(CamerasOf(first), CamerasOf(second), sightings, &fit, &error)) {
    throw InputError(error + ": are mesh and cameras in the same frame?");
  }
  evaluation.truth_from_scene = on_truth ? fit.second_from_first.Inverse() : fit.second_from_first;
  evaluation.views_with_points = fit.errors.views;
  evaluation.rms_px = fit.errors.rms_px;
  double worst_px = -1;
  for (size_t v = 0; v < first.size(); ++v) {
    const Camera moved = Moved(common.scene[v].camera, evaluation.truth_from_scene);
    const Camera& true_camera = common.truth[v].camera;
    ViewCameraErrors& view = evaluation.views.emplace_back();
    view.name = common.scene[v].name;
    view.points = static_cast<int>(sightings[v].size());
    view.behind = fit.errors.behind[v];
    view.px = fit.errors.view_px[v];
    view.center_distance = (moved.Center() - true_camera.Center()).norm();
    view.angle_deg =
        Similarity{1, moved.rotation * true_camera.rotation.transpose(), {0, 0, 0}}.AngleDeg();
    if (view.px > worst_px) {
      worst_px = view.px;
      evaluation.worst = static_cast<int>(v);
    }
  }
  return evaluation;
}

}  // namespace burin
