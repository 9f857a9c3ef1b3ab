#include "core/scene/formats/middlebury.h"

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/text_lines.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr char kEnding[] = "_par.txt";

// Empty when there is none.
fs::path ParameterFile(const fs::path& path) {
  if (EndsIn(path.filename().string(), kEnding)) return path;
  const std::vector<fs::path> files = FilesEndingIn(path, kEnding);
  if (files.size() > 1) {
    throw InputError(path, "has " + files[0].filename().string() + " and " +
                               files[1].filename().string() + ": name the one to read");
  }
  return files.empty() ? fs::path() : files[0];
}

Eigen::Matrix3d ReadMatrix(TextLines* lines, const char* field) {
  Eigen::Matrix3d matrix;
  for (int k = 0; k < 9; ++k) matrix(k / 3, k % 3) = lines->Number<double>(field);
  return matrix;
}

}  // namespace

bool IsMiddlebury(const fs::path& path) { return !ParameterFile(path).empty(); }

PosedScene ReadMiddlebury(const fs::path& path, const fs::path& images) {
  const fs::path file = ParameterFile(path);
  const fs::path folder = images.empty() ? file.parent_path() : images;
  TextLines lines(file);
  if (!lines.NextElement()) lines.Fail("number of images", "is missing");
  const auto count = lines.Number<uint32_t>("number of images");
  lines.ExpectEndOfLine();
  PosedScene posed;
  posed.file = file;
  std::vector<fs::path> photographs;
  while (lines.NextElement()) {
    PosedImage& view = posed.images.emplace_back();
    view.name = std::string(lines.Word("image name"));
    const std::string element = view.name + ": ";
    view.camera = CameraOfIntrinsics(ReadMatrix(&lines, "K"), 0, file, element + "K");
    view.camera.rotation = NearestRotation(ReadMatrix(&lines, "R"), file, element + "R");
    view.camera.translation = lines.Vector3("t1", "t2", "t3");
    lines.ExpectEndOfLine();
    view.image_path = FindPhotograph(view.name, {folder});
    photographs.push_back(view.image_path);
  }
  if (posed.images.size() != count) {
    throw InputError(file, "number of images = " + std::to_string(count) + ", but " +
                               std::to_string(posed.images.size()) + " follow");
  }
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  for (size_t i = 0; i < sizes.size(); ++i) {
    posed.images[i].camera.width = sizes[i].width;
    posed.images[i].camera.height = sizes[i].height;
  }
  return posed;
}

}  // namespace burin
