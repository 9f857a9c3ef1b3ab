#include "core/cameras/lens_change.h"

#include <limits>

#include "core/scene/formats/posed_images.h"

namespace burin {
namespace {

bool HaveOneLens(const View& from, const Camera& camera, const Lens& lens) {
  const Lens& was = from.origin.lens;
  if (was.IsNone() && lens.IsNone()) return true;
  return camera.HasIntrinsicsOf(from.camera) && was.brown == lens.brown &&
         was.measured == lens.measured;
}

std::vector<LensChange> ChangesOf(const Scene& scene, const std::vector<Camera>& cameras,
                                  const std::vector<Lens>& lenses) {
  std::vector<LensChange> changes;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    changes.emplace_back(scene.views[v], cameras[v], lenses[v]);
  }
  return changes;
}

}  // namespace

LensChange::LensChange(const View& from, const Camera& camera, const Lens& lens)
    : same_(HaveOneLens(from, camera, lens)),
      camera_(from.camera),
      lens_(from.origin.lens),
      undistort_(camera, lens) {}

std::optional<Eigen::Vector2d> LensChange::operator()(const Eigen::Vector2d& undistorted) const {
  if (same_) return undistorted;
  return undistort_(PhotographedAt(camera_, lens_, undistorted));
}

MeshTracks SeenThrough(const MeshTracks& tracks, const Scene& scene,
                       const std::vector<Camera>& cameras, const std::vector<Lens>& lenses) {
  if (lenses.empty()) return tracks;
  const std::vector<LensChange> changes = ChangesOf(scene, cameras, lenses);
  MeshTracks seen{tracks.points, tracks.windows, {},
                  tracks.pixel,  tracks.groups,  tracks.sparse_scale};
  for (size_t p = 0; p < tracks.tracks.PointCount(); ++p) {
    seen.tracks.BeginPoint();
    for (Measurement measured : tracks.tracks.Of(p)) {
      measured.image_point =
          changes[measured.view](measured.image_point)
              .value_or(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
      seen.tracks.Add(measured);
    }
  }
  return seen;
}

std::vector<std::vector<Sighting>> SightingsThrough(
    const Scene& scene, const std::vector<std::vector<Eigen::Vector3d>>& points,
    const std::vector<Camera>& cameras, const std::vector<Lens>& lenses) {
  std::vector<std::vector<Sighting>> sightings = SightingsOf(CamerasOf(scene), points);
  if (lenses.empty()) return sightings;
  const std::vector<LensChange> changes = ChangesOf(scene, cameras, lenses);
  for (size_t v = 0; v < sightings.size(); ++v) {
    std::vector<Sighting> kept;
    for (const Sighting& seen : sightings[v]) {
      const std::optional<Eigen::Vector2d> at = changes[v](seen.pixel);
      if (at.has_value()) kept.push_back({seen.point, *at});
    }
    sightings[v] = kept;
  }
  return sightings;
}

Scene WithIntrinsics(const Scene& scene, const std::vector<Camera>& cameras,
                     const std::vector<Lens>& lenses) {
  if (lenses.empty()) return scene;
  Scene with = scene;
  std::vector<View*> anew;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    View& view = with.views[v];
    view.camera.fx = cameras[v].fx;
    view.camera.fy = cameras[v].fy;
    view.camera.cx = cameras[v].cx;
    view.camera.cy = cameras[v].cy;
    view.origin.lens = lenses[v];
    if (!HaveOneLens(scene.views[v], cameras[v], lenses[v])) anew.push_back(&view);
  }
  ReadPixels(anew);
  if (anew.empty() || scene.tracks.IsEmpty()) return with;
  const std::vector<LensChange> changes = ChangesOf(scene, cameras, lenses);
  with.tracks = Tracks();
  for (size_t p = 0; p < scene.tracks.PointCount(); ++p) {
    with.tracks.BeginPoint();
    for (Measurement measured : scene.tracks.Of(p)) {
      const std::optional<Eigen::Vector2d> at = changes[measured.view](measured.image_point);
      if (!at.has_value()) continue;
      measured.image_point = *at;
      with.tracks.Add(measured);
    }
  }
  return with;
}

}  // namespace burin
