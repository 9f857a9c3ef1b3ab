#include "apps/commands/pair_pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/image/picture.h"
#include "core/visibility/render.h"

namespace burin {
namespace {

constexpr int kGraphSize = 1000;  // px
constexpr int kViewWidth = 640;   // px, of a coverage picture
constexpr int kMatrixSize = 900;  // px
const cv::Scalar kPairColor(170, 80, 20);
const cv::Scalar kCameraColor(30, 30, 200);
const cv::Scalar kTextColor(20, 20, 20);

// Mean upward direction of the images; for views rolled in every way, any direction.
Eigen::Vector3d UpOf(const Scene& scene) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const View& view : scene.views) up -= view.camera.rotation.row(1).transpose();
  return up.norm() > 1e-6 ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d::UnitY();
}

// Value below which `share` of the values lie.
double Quantile(std::vector<double> values, double share) {
  const auto nth =
      values.begin() + static_cast<long>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

// A camera so far above everything that it sees as good as no perspective. Cameras are in the
// picture with a margin; of the mesh, stray vertices may fall outside.
Camera CameraFromAbove(const Scene& scene, const TriangleMesh& mesh) {
  const Eigen::Vector3d up = UpOf(scene);
  Eigen::Vector3d ahead = Eigen::Vector3d::Zero();
  for (const View& view : scene.views) ahead += view.camera.rotation.row(2).transpose();
  ahead -= ahead.dot(up) * up;
  if (ahead.norm() < 1e-3 * static_cast<double>(scene.views.size())) ahead = up.unitOrthogonal();
  Camera above;
  above.rotation.row(1) = -ahead.normalized();
  above.rotation.row(2) = -up;
  above.rotation.row(0) = above.rotation.row(1).cross(above.rotation.row(2));
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      values.push_back(above.rotation.row(c).dot(vertex));
    }
    low[c] = Quantile(values, 0.02);
    high[c] = Quantile(values, 0.98);
    for (const View& view : scene.views) {
      const double value = above.rotation.row(c).dot(view.camera.Center());
      low[c] = std::min(low[c], value);
      high[c] = std::max(high[c], value);
    }
  }
  const double extent = 1.15 * std::max(high[0] - low[0], high[1] - low[1]);
  const Eigen::Vector3d middle = 0.5 * (low + high);
  const double distance = 50 * std::max(extent, high[2] - low[2]);
  above.width = above.height = kGraphSize;
  above.fx = above.fy = kGraphSize * distance / extent;
  above.cx = above.cy = 0.5 * kGraphSize;
  above.translation = -middle + Eigen::Vector3d(0, 0, distance);
  return above;
}

cv::Point At(const Camera& camera, const Eigen::Vector3d& point) {
  const Eigen::Vector2d image = camera.Project(point);
  return {static_cast<int>(std::lround(image.x())), static_cast<int>(std::lround(image.y()))};
}

// Up to three views whose directions of view lie far apart, beginning with the middle one.
std::vector<int> ViewsFarApart(const Scene& scene) {
  std::vector<int> chosen = {static_cast<int>(scene.views.size() / 2)};
  while (chosen.size() < 3 && chosen.size() < scene.views.size()) {
    int best = 0;
    double best_cosine = 2;
    for (size_t i = 0; i < scene.views.size(); ++i) {
      double cosine = -1;  // of the nearest chosen one
      for (const int c : chosen) {
        cosine = std::max(cosine, scene.views[i].camera.rotation.row(2).dot(
                                      scene.views[c].camera.rotation.row(2)));
      }
      if (cosine < best_cosine) {
        best_cosine = cosine;
        best = static_cast<int>(i);
      }
    }
    chosen.push_back(best);
  }
  return chosen;
}

}  // namespace

cv::Mat3b PairGraphPicture(const Scene& scene, const TriangleMesh& mesh,
                           const std::vector<CameraPair>& pairs) {
  const Camera above = CameraFromAbove(scene, mesh);
  cv::Mat3b picture = RenderShaded(mesh, above);
  picture = picture * 0.5 + cv::Scalar(127, 127, 127);
  for (const CameraPair& pair : pairs) {
    const cv::Point from = At(above, scene.views[pair.reference].camera.Center());
    const cv::Point to = At(above, scene.views[pair.second].camera.Center());
    const double length = std::max(1.0, cv::norm(to - from));
    cv::arrowedLine(picture, from, to, kPairColor, 1, cv::LINE_AA, 0, std::min(0.2, 12 / length));
  }
  const double pixel = above.translation.z() / above.fx;
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const Camera& camera = scene.views[i].camera;
    const cv::Point center = At(above, camera.Center());
    const Eigen::Vector3d ahead = camera.rotation.row(2);
    cv::line(picture, center, At(above, camera.Center() + 25 * pixel * ahead), kCameraColor, 2,
             cv::LINE_AA);
    cv::circle(picture, center, 5, kCameraColor, cv::FILLED, cv::LINE_AA);
    if (scene.views.size() <= 60) {
      DrawText(std::to_string(i), center + cv::Point(8, 12), {40, 16}, &picture);
    }
  }
  return picture;
}

cv::Mat3b CoveragePicture(const Scene& scene, const TriangleMesh& mesh,
                          const std::vector<int>& before, const std::vector<int>& after) {
  ColorScale scale;
  scale.max = 1;
  for (const auto* counts : {&before, &after}) {
    for (const int count : *counts) scale.max = std::max(scale.max, static_cast<double>(count));
  }
  scale.label = "pairs";
  cv::Mat3b all;
  for (const int view : ViewsFarApart(scene)) {
    const Camera& full = scene.views[view].camera;
    const double shrink = std::max(1.0, static_cast<double>(full.width) / kViewWidth);
    const Camera camera = full.Resized(std::max(1, static_cast<int>(full.width / shrink)),
                                       std::max(1, static_cast<int>(full.height / shrink)));
    const auto render = [&](const std::vector<int>& counts) {
      const std::vector<double> values(counts.begin(), counts.end());
      return RenderFaceScalar(mesh, camera, values, scale);
    };
    const std::string& name = scene.views[view].name;
    const cv::Mat3b row = SideBySide({render(before), render(after)},
                                     {name + ", before Algorithm 1", name + ", after"});
    if (all.empty()) {
      all = row;
      continue;
    }
    cv::Mat3b taller(all.rows + row.rows, std::max(all.cols, row.cols), cv::Vec3b(255, 255, 255));
    all.copyTo(taller(cv::Rect(0, 0, all.cols, all.rows)));
    row.copyTo(taller(cv::Rect(0, all.rows, row.cols, row.rows)));
    all = taller;
  }
  return all;
}

cv::Mat3b EnergyMatrixPicture(const Scene& scene, const std::vector<double>& energies,
                              const std::vector<CameraPair>& pairs) {
  const int n = static_cast<int>(scene.views.size());
  const int cell = std::max(2, kMatrixSize / n);
  const int margin = n <= 60 ? 60 : 0;
  ColorScale scale;
  scale.label = "E_BPV";
  scale.min = *std::min_element(energies.begin(), energies.end());
  scale.max = scale.min;  // the worst candidate
  for (const double energy : energies) {
    if (energy < 0) scale.max = scale.max < 0 ? std::max(scale.max, energy) : energy;
  }
  if (scale.max - scale.min < 1e-6) scale.max = scale.min + 1e-6;
  cv::Mat3b picture(margin + n * cell, margin + n * cell, cv::Vec3b(255, 255, 255));
  const auto square = [&](int i, int j) {
    return cv::Rect(margin + j * cell, margin + i * cell, cell, cell);
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double energy = energies[static_cast<size_t>(i) * n + j];
      if (energy < 0) picture(square(i, j)) = ScaleColor(scale, energy);
    }
    if (margin == 0) continue;
    const cv::Size text(margin - 10, std::min(16, cell));
    DrawText(std::to_string(i), {5, margin + i * cell + cell / 2}, text, &picture);
    DrawText(std::to_string(i), {margin + i * cell + cell / 4, margin / 2},
             {std::max(8, cell / 2), std::min(16, cell)}, &picture);
  }
  for (const CameraPair& pair : pairs) {
    cv::rectangle(picture, square(pair.reference, pair.second), kCameraColor,
                  std::max(1, cell / 14));
  }
  return WithColorBar(picture, scale);
}

}  // namespace burin
