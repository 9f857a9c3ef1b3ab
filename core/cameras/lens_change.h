// Other intrinsics and lenses of the same photographs: what the undistorted image shows at one place is at another
// place of the image that they undistort.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/cameras/mesh_tracks.h"
#include "core/scene/camera.h"
#include "core/scene/camera_similarity.h"
#include "core/scene/lens_points.h"
#include "core/scene/scene.h"

namespace burin {

class LensChange {
 public:
  LensChange(const View& from, const Camera& camera, const Lens& lens);
  // Nothing where the new lens takes the place from nowhere. Without lenses every place stays.
  std::optional<Eigen::Vector2d> operator()(const Eigen::Vector2d& undistorted) const;

 private:
  bool same_;
  Camera camera_;
  Lens lens_;
  PointUndistortion undistort_;
};

// All three are of the scene's views, and leave everything as it is where `lenses` is empty.

// Measurements in the images of these cameras and lenses; not a number where these have no place for one.
MeshTracks SeenThrough(const MeshTracks& tracks, const Scene& scene,
                       const std::vector<Camera>& cameras, const std::vector<Lens>& lenses);

// Where the scene's views see points, in the images of these cameras and lenses.
std::vector<std::vector<Sighting>> SightingsThrough(
    const Scene& scene, const std::vector<std::vector<Eigen::Vector3d>>& points,
    const std::vector<Camera>& cameras, const std::vector<Lens>& lenses);

// The scene with these intrinsics, its poses as they are: photographs and masks with a lens are read and undistorted again, and the
// measurements of its sparse points are in the images that this makes.
Scene WithIntrinsics(const Scene& scene, const std::vector<Camera>& cameras,
                     const std::vector<Lens>& lenses);

}  // namespace burin
