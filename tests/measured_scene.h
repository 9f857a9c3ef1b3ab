// A scene with measurements, and what tests ask of such.
#pragma once

#include <algorithm>
#include <iomanip>
#include <opencv2/calib3d.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace burin {

// Three views in a row of 320x240 pixels, 40 points before them that all see, each measured off its
// projection by its own part of a pixel.
inline Scene MeasuredScene() {
  Scene scene;
  for (int v = 0; v < 3; ++v) {
    View& view = scene.views.emplace_back();
    view.name = std::string(1, static_cast<char>('c' - v)) + ".png";
    view.camera.width = 320;
    view.camera.height = 240;
    view.camera.fx = view.camera.fy = 300;
    view.camera.cx = 160;
    view.camera.cy = 120;
    view.camera.rotation =
        Eigen::AngleAxisd(0.1 * (v - 1), Eigen::Vector3d(0.1, 1, 0).normalized()).matrix();
    view.camera.translation = {0.5 * (v - 1), 0.02 * v, 4};
    view.gray = cv::Mat(240, 320, CV_8UC1, cv::Scalar(50 * v));
    view.origin.image_id = 30 - 10 * v;
    view.origin.camera_id = 7;
  }
  for (int p = 0; p < 40; ++p) {
    ScenePoint& point = scene.points.emplace_back();
    point.position = {0.25 * (p % 8) - 0.9, 0.4 * (p / 8) - 0.8, 0.1 * (p % 5)};
    point.views = {0, 1, 2};
    point.id = 100 - p;
    scene.tracks.BeginPoint();
    for (int v = 0; v < 3; ++v) {
      const Eigen::Vector2d off(0.01 * p, -0.02 * p + 0.3 * v);
      scene.tracks.Add({scene.views[v].camera.Project(point.position) + off, v});
    }
  }
  return scene;
}

// One line a measurement: point id, view's name and place, sorted.
inline std::vector<std::string> Lines(const Scene& scene, int digits) {
  std::vector<std::string> lines;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    for (const Measurement& measured : scene.tracks.Of(p)) {
      std::ostringstream line;
      line << scene.points[p].id << " " << scene.views[measured.view].name << std::fixed
           << std::setprecision(digits) << " " << measured.image_point.transpose();
      lines.push_back(line.str());
    }
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

inline double WorstError(const Scene& scene) {
  double worst = 0;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    for (const Measurement& measured : scene.tracks.Of(p)) {
      const Camera& camera = scene.views[measured.view].camera;
      worst =
          std::max(worst, (camera.Project(scene.points[p].position) - measured.image_point).norm());
    }
  }
  return worst;
}

// A lens, and where it photographs a point of the camera frame at unit depth, by another program's formula.
inline cv::Point2d ByOpenCv(const Lens& lens, const cv::Point3d& point) {
  std::vector<cv::Point2d> photographed;
  cv::projectPoints(std::vector<cv::Point3d>{point}, cv::Vec3d(), cv::Vec3d(), cv::Matx33d::eye(),
                    cv::Vec<double, 5>(lens.brown.data()), photographed);
  return photographed[0];
}

}  // namespace burin
