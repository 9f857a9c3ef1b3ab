#include "core/visibility/silhouette.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "core/support/error.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kPointGrain = 4096;
constexpr double kShapeTolerance = 0.01;  // of width / height

// 255 where a pixel is within `radius_px` of a step between it and a neighbour.
cv::Mat1b NearSteps(const cv::Mat1f& depth, double focal, const SilhouetteOptions& options) {
  cv::Mat1b step(depth.size(), static_cast<uchar>(255));  // 0 = step, for the distance transform
  const auto is_step = [&](float a, float b) {
    if ((a > 0) != (b > 0)) return true;
    return a > 0 && std::abs(a - b) > options.step_px * std::min(a, b) / focal;
  };
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const bool right = x + 1 < depth.cols && is_step(depth(y, x), depth(y, x + 1));
      const bool below = y + 1 < depth.rows && is_step(depth(y, x), depth(y + 1, x));
      if (right) step(y, x) = step(y, x + 1) = 0;
      if (below) step(y, x) = step(y + 1, x) = 0;
    }
  }
  cv::Mat1f distance;
  cv::distanceTransform(step, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance <= options.radius_px;
}

}  // namespace

std::vector<char> NearSilhouettes(const std::vector<Eigen::Vector3d>& points,
                                  const std::vector<Camera>& cameras,
                                  const std::vector<cv::Mat1f>& depth,
                                  const SilhouetteOptions& options) {
  std::vector<char> near(points.size(), 0);
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (depth[i].empty()) continue;
    const Camera camera = cameras[i].Resized(depth[i].cols, depth[i].rows);
    const double focal = std::sqrt(camera.fx * camera.fy);
    const cv::Mat1b near_steps = NearSteps(depth[i], focal, options);
    ParallelFor(static_cast<int>(points.size()), kPointGrain, [&](int begin, int end) {
      for (int p = begin; p < end; ++p) {
        const double z = camera.Depth(points[p]);
        if (near[p] != 0 || z <= 0) continue;
        const Eigen::Vector2d image = camera.Project(points[p]);
        if (!camera.Contains(image)) continue;
        const int x = std::min(camera.width - 1, static_cast<int>(image.x()));
        const int y = std::min(camera.height - 1, static_cast<int>(image.y()));
        if (near_steps(y, x) == 0) continue;
        // On the near side of a step the pixel may show what lies beyond: look around.
        const double tolerance = options.visible_px * z / focal;
        for (int v = std::max(0, y - 1); v <= std::min(camera.height - 1, y + 1); ++v) {
          for (int u = std::max(0, x - 1); u <= std::min(camera.width - 1, x + 1); ++u) {
            if (depth[i](v, u) > 0 && std::abs(depth[i](v, u) - z) <= tolerance) near[p] = 1;
          }
        }
      }
    });
  }
  return near;
}

std::vector<cv::Mat1f> ReadDepthMaps(const std::filesystem::path& folder, const Scene& scene,
                                     double png_unit) {
  std::vector<cv::Mat1f> maps(scene.views.size());
  bool any = false;
  std::map<std::filesystem::path, int> files_of_name;
  for (const View& view : scene.views) {
    ++files_of_name[std::filesystem::path(view.name).replace_extension().filename()];
  }
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const std::filesystem::path name =
        std::filesystem::path(scene.views[i].name).replace_extension();
    std::filesystem::path path;
    double unit = 1;
    for (const std::filesystem::path& stem : {name, name.filename()}) {
      if (stem != name && files_of_name[stem] > 1) continue;  // whose would it be?
      for (const char* ending : {".tiff", "_depth.png"}) {
        const std::filesystem::path file = folder / (stem.string() + ending);
        std::error_code error;
        if (!path.empty() || !std::filesystem::exists(file, error)) continue;
        path = file;
        unit = file.extension() == ".png" ? png_unit : 1;
      }
    }
    if (path.empty()) continue;
    const cv::Mat map = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
    if (map.empty() || map.channels() != 1) {
      throw InputError(path, "is not a readable depth map with one channel");
    }
    const Camera& camera = scene.views[i].camera;
    const double shape = static_cast<double>(map.cols) / map.rows * camera.height / camera.width;
    if (std::abs(shape - 1) > kShapeTolerance) {
      throw InputError(path, "depth map: is " + std::to_string(map.cols) + " x " +
                                 std::to_string(map.rows) + " but the image " +
                                 std::to_string(camera.width) + " x " +
                                 std::to_string(camera.height));
    }
    map.convertTo(maps[i], CV_32F, unit);
    any = true;
  }
  if (!any) {
    throw InputError(folder, "no depth map: for a view NAME.jpg, NAME.tiff or NAME_depth.png");
  }
  return maps;
}

}  // namespace burin
