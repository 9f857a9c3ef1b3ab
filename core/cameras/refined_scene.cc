#include "core/cameras/refined_scene.h"

#include "core/cameras/bundle.h"

namespace burin {

Scene WithRefinedCameras(const Scene& scene, const std::vector<Camera>& cameras) {
  Scene refined = WithCameras(scene, cameras);
  if (AreCamerasOf(scene, cameras)) return refined;
  const std::vector<double> pixel(cameras.size(), 1);
  for (size_t p = 0; p < scene.tracks.PointCount(); ++p) {
    const Tracks::Range track = scene.tracks.Of(p);
    Eigen::Vector3d point;
    if (track.size() >= 2 && Triangulate(cameras, track, pixel, 1, &point)) {
      refined.points[p].position = point;
    }
  }
  return refined;
}

}  // namespace burin
