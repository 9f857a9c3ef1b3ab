#include "core/scene/formats/photograph_checks.h"

#include <cstdlib>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "core/image/image_size.h"
#include "core/support/error.h"
#include "core/support/fixed_text.h"
#include "core/support/spelling.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

// Whether both sides were scaled by one factor, to a pixel.
bool IsScaled(const Camera& camera, const cv::Size& size) {
  const auto off = std::llabs(static_cast<long long>(camera.width) * size.height -
                              static_cast<long long>(camera.height) * size.width);
  return off <= std::max(camera.width, camera.height);
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

void FindSpellings(PosedScene* posed) {
  for (PosedImage& image : posed->images) image.image_path = AsSpelled(image.image_path);
}

void CheckOneViewAPhotograph(const PosedScene& posed) {
  std::map<fs::path, const PosedImage*> of_file;
  for (const PosedImage& image : posed.images) {
    std::error_code error;
    const fs::path file = fs::canonical(image.image_path, error);
    if (error) continue;  // missing
    const auto [first, is_new] = of_file.emplace(file, &image);
    if (is_new) continue;
    throw InputError(posed.file, "image " + image.name + ": its photograph " +
                                     image.image_path.string() + " is that of image " +
                                     first->second->name + " too: a view has one of its own");
  }
}

void RequirePhotographs(const PosedScene& posed) {
  for (const PosedImage& image : posed.images) {
    if (Exists(image.image_path)) continue;
    throw InputError(image.image_path, "file is missing; --skip-views '" + image.name +
                                           "' leaves its view out, --images DIR says where "
                                           "photographs are");
  }
}

void ScaleToPhotographs(PosedScene* posed) {
  std::vector<Eigen::Vector2d> factors(posed->images.size(), Eigen::Vector2d::Ones());
  int scaled = 0;
  std::string first;
  for (size_t i = 0; i < posed->images.size(); ++i) {
    PosedImage& image = posed->images[i];
    Camera& camera = image.camera;
    if (!Exists(image.image_path) || camera.width <= 0 || camera.height <= 0) continue;
    const cv::Size size = ImageSize(image.image_path);
    if (size == cv::Size(camera.width, camera.height) || !IsScaled(camera, size)) continue;
    const double x = static_cast<double>(size.width) / camera.width;
    const double y = static_cast<double>(size.height) / camera.height;
    if (++scaled == 1) {
      first = image.name + ": photograph of " + SizeText(size.width, size.height) + " for " +
              image.camera_name + " of " + SizeText(camera.width, camera.height) +
              ": the camera is scaled by " + Fixed(x, 3);
    }
    factors[i] = {x, y};
    camera.fx *= x;
    camera.cx *= x;
    camera.fy *= y;
    camera.cy *= y;
    camera.width = size.width;
    camera.height = size.height;
  }
  if (scaled == 0) return;
  posed->tracks.Scale(factors);
  posed->notes.push_back(first +
                         (scaled > 1 ? " (" + std::to_string(scaled) + " views like it)" : ""));
}

}  // namespace burin
