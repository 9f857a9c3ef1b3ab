// A scene: what a reader returns and the pipeline takes. It has calibrated views with their grey images,
// and what the structure-from-motion run knew: sparse points with the views that see each, where it measured
// them, the lenses of the photographs and its own numbers.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/tracks.h"
#include "core/scene/undistort.h"

namespace burin {

// Of what the format gives no number.
constexpr std::uint64_t kNoId = std::numeric_limits<std::uint64_t>::max();

// The photograph as it was before it was undistorted, in the words of its format.
struct Origin {
  std::uint64_t image_id = kNoId;
  std::uint64_t camera_id = kNoId;  // photographs with the same one share intrinsics and lens
  std::string camera_model;  // "OPENCV", "pinhole_radial_k3"; empty where there is one model only
  Lens lens;  // size, focal length and principal point were those of the undistorted camera
};

struct View {
  std::string name;                  // as in the model, unique in a scene
  std::filesystem::path image_path;  // where the pixels came from; empty for scenes made in memory
  std::filesystem::path mask_path;   // where the mask came from; empty = from no file
  Camera camera;                     // of the undistorted image
  cv::Mat
      gray;  // CV_8UC1 or CV_32FC1 (grey levels 0..255), camera.width x camera.height, undistorted
  cv::Mat mask;  // CV_8UC1 of the same size, 0 = pixel not to be used; empty = all are
  Origin origin;
  // What of each pixel the object covers, where masks say that (core/scene/mask_options.h): CV_8UC1 of the same size,
  // 0 = nothing, 255 = all; empty = not known.
  cv::Mat object;
  // Where the lens leaves `object` unknown: CV_8UC1, 0 = outside the photograph; empty = nowhere.
  cv::Mat photographed;
};

struct ScenePoint {
  Eigen::Vector3d position;  // world units
  std::vector<int> views;    // indices into Scene::views, ascending, no repeats
  std::uint64_t id = kNoId;  // of the format
};

struct Scene {
  std::vector<View> views;
  std::vector<ScenePoint> points;  // may be empty
  // Of every point, in pixels of the undistorted images, so that view.camera.Project(point.position) is to be
  // compared with them; in double, whatever is outside the picture included. A measurement whose place the
  // lens cannot have taken from anywhere is left out, while the point keeps its view. Empty, or a track a
  // point. Views that formats without measurements give are in ScenePoint::views only.
  Tracks tracks;
  // What its reader did that the user may not expect (views left out, cameras scaled, ...), a line each.
  std::vector<std::string> notes;
};

std::vector<Camera> CamerasOf(const Scene& scene);

// Whether these are the poses and intrinsics of the scene's views.
bool AreCamerasOf(const Scene& scene, const std::vector<Camera>& cameras);

// `scene` with other cameras of its views. Pixels are shared.
Scene WithCameras(const Scene& scene, const std::vector<Camera>& cameras);

// `scene` without the views whose new index is -1; the others keep their order: index[v] counts those kept
// before v. Points keep their place, with what is left of their views and tracks. Pixels are shared.
Scene WithoutViews(const Scene& scene, const std::vector<int>& index);

}  // namespace burin
