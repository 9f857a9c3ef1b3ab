#include "core/scene/formats/strecha.h"

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/text_lines.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

Camera ReadCameraFile(const fs::path& path) {
  TextLines lines(path);
  const Eigen::Matrix3d k = lines.Rows<3, 3>("K");
  const Eigen::Vector3d zero = lines.Rows<1, 3>("distortion").transpose();
  if (!zero.isZero(0)) lines.Fail("distortion", "must be 0 0 0");
  const Eigen::Matrix3d rotation = lines.Rows<3, 3>("R");
  const Eigen::Vector3d center = lines.Rows<1, 3>("centre").transpose();
  const Eigen::Vector2d size = lines.Rows<1, 2>("width and height").transpose();
  if (!(size.minCoeff() >= 1 && size.maxCoeff() <= 1e6)) {
    lines.Fail("width and height", "must be in [1, 1000000]");
  }
  Camera camera = CameraOfIntrinsics(k, 0, path, "K");
  camera.width = static_cast<int>(size.x());
  camera.height = static_cast<int>(size.y());
  camera.rotation = NearestRotation(rotation, path, "R").transpose();
  camera.translation = -camera.rotation * center;
  return camera;
}

// To the photograph's size, when that is the camera's times one factor.
Camera Fitted(const Camera& camera, cv::Size size) {
  const bool same_shape = std::abs(static_cast<double>(camera.width) * size.height -
                                   static_cast<double>(camera.height) * size.width) <=
                          std::max(camera.width, camera.height);
  return same_shape ? camera.Resized(size.width, size.height) : camera;
}

}  // namespace

bool IsStrecha(const fs::path& path) {
  return !FilesEndingIn(path, ".camera").empty() || !FilesEndingIn(path, ".P").empty();
}

PosedScene ReadStrecha(const fs::path& path, const fs::path& images) {
  std::string ending = ".camera";
  std::vector<fs::path> files = FilesEndingIn(path, ending);
  if (files.empty()) {
    ending = ".P";
    files = FilesEndingIn(path, ending);
  }
  PosedScene posed;
  posed.file = path;
  std::vector<fs::path> photographs;
  for (const fs::path& file : files) {
    PosedImage& view = posed.images.emplace_back();
    view.name = file.stem().string();
    view.image_path = FindPhotograph(
        view.name, images.empty() ? std::vector<fs::path>{path, path / "images", path / "../images"}
                                  : std::vector<fs::path>{images});
    view.camera_name = "the camera of " + file.filename().string();
    photographs.push_back(view.image_path);
  }
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  for (size_t i = 0; i < files.size(); ++i) {
    Camera& camera = posed.images[i].camera;
    if (ending == ".P") {
      TextLines lines(files[i]);
      camera = CameraOfProjection(lines.Rows<3, 4>("P"), sizes[i], files[i], "P");
    } else {
      camera = Fitted(ReadCameraFile(files[i]), sizes[i]);
    }
  }
  return posed;
}

}  // namespace burin
