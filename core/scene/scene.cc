#include "core/scene/scene.h"

#include <utility>

namespace burin {

std::vector<Camera> CamerasOf(const Scene& scene) {
  std::vector<Camera> cameras;
  cameras.reserve(scene.views.size());
  for (const View& view : scene.views) cameras.push_back(view.camera);
  return cameras;
}

bool AreCamerasOf(const Scene& scene, const std::vector<Camera>& cameras) {
  for (size_t v = 0; v < cameras.size(); ++v) {
    const Camera& camera = scene.views[v].camera;
    if (camera.rotation != cameras[v].rotation || camera.translation != cameras[v].translation ||
        !camera.HasIntrinsicsOf(cameras[v])) {
      return false;
    }
  }
  return true;
}

Scene WithCameras(const Scene& scene, const std::vector<Camera>& cameras) {
  Scene with = scene;
  for (size_t v = 0; v < cameras.size(); ++v) with.views[v].camera = cameras[v];
  return with;
}

Scene WithoutViews(const Scene& scene, const std::vector<int>& index) {
  Scene without;
  without.notes = scene.notes;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    if (index[v] >= 0) without.views.push_back(scene.views[v]);
  }
  for (const ScenePoint& point : scene.points) {
    ScenePoint kept{point.position, {}, point.id};
    for (const int view : point.views) {
      if (index[view] >= 0) kept.views.push_back(index[view]);
    }
    without.points.push_back(std::move(kept));
  }
  for (size_t p = 0; p < scene.tracks.PointCount(); ++p) {
    without.tracks.BeginPoint();
    for (Measurement measurement : scene.tracks.Of(p)) {
      measurement.view = index[measurement.view];
      if (measurement.view >= 0) without.tracks.Add(measurement);
    }
  }
  return without;
}

}  // namespace burin
