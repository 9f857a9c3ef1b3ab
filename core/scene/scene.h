// A scene: what a reader returns and the pipeline takes. It has calibrated views with their grey images,
// and the sparse points of the structure-from-motion run with the views that see each point.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/scene/camera.h"

namespace burin {

struct View {
  std::string name;                  // as in the model, unique in a scene
  std::filesystem::path image_path;  // where the pixels came from; empty for scenes made in memory
  Camera camera;                     // of the undistorted image
  cv::Mat
      gray;  // CV_8UC1 or CV_32FC1 (grey levels 0..255), camera.width x camera.height, undistorted
  cv::Mat mask;  // CV_8UC1 of the same size, 0 = pixel not to be used; empty = all are
};

struct ScenePoint {
  Eigen::Vector3d position;  // world units
  std::vector<int> views;    // indices into Scene::views, ascending, no repeats
};

struct Scene {
  std::vector<View> views;
  std::vector<ScenePoint> points;  // may be empty
};

}  // namespace burin
