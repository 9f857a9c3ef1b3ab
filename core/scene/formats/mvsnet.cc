#include "core/scene/formats/mvsnet.h"

#include <Eigen/Core>
#include <cctype>
#include <cmath>
#include <string>
#include <system_error>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/text_lines.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr char kMvsNetEnding[] = "_cam.txt";

void ExpectWord(TextLines* lines, const char* word) {
  if (!lines->NextElement()) lines->Fail(word, "the file ends");
  if (lines->Word(word) != word) lines->Fail(word, "is missing here");
  lines->ExpectEndOfLine();
}

std::vector<fs::path> PhotographFolders(const fs::path& cameras, const fs::path& images) {
  if (!images.empty()) return {images};
  return {cameras, cameras / "images", cameras / "blended_images", cameras / ".." / "images",
          cameras / ".." / "blended_images"};
}

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Whether `number` is in `name` with no digit before and after.
bool HasNumber(const std::string& name, const std::string& number) {
  for (size_t at = name.find(number); at != std::string::npos; at = name.find(number, at + 1)) {
    const size_t end = at + number.size();
    if ((at == 0 || !IsDigit(name[at - 1])) && (end == name.size() || !IsDigit(name[end]))) {
      return true;
    }
  }
  return false;
}

fs::path PhotographOfNumber(const std::string& number, const fs::path& file,
                            const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    fs::path last;
    for (const fs::path& candidate : PhotographsIn(folder)) {
      if (HasNumber(candidate.stem().string(), number)) last = candidate;
    }
    if (!last.empty()) return last;
  }
  throw InputError(file, "no photograph has the number " + number +
                             " in its name; --images DIR says where they are");
}

// pos_NNN.txt: NNN, or nothing for other names.
std::string DtuNumber(const fs::path& path) {
  const std::string stem = path.stem().string();
  if (stem.rfind("pos_", 0) != 0 || stem.size() == 4) return {};
  for (size_t k = 4; k < stem.size(); ++k) {
    if (!IsDigit(stem[k])) return {};
  }
  return stem.substr(4);
}

std::vector<fs::path> DtuFiles(const fs::path& path) {
  std::vector<fs::path> files;
  for (const fs::path& file : FilesEndingIn(path, ".txt")) {
    if (!DtuNumber(file).empty()) files.push_back(file);
  }
  return files;
}

// MVSNet's files for DTU have the K of the data set's rectified photographs, all of them the same.
bool IsOfDtu(const Camera& camera) {
  constexpr double kTolerance = 0.1;  // pixels
  return camera.width == 1600 && camera.height == 1200 &&
         std::abs(camera.fx - 2892.33) < kTolerance && std::abs(camera.fy - 2883.18) < kTolerance &&
         std::abs(camera.cx - 823.205) < kTolerance && std::abs(camera.cy - 619.071) < kTolerance;
}

fs::path MvsNetFolder(const fs::path& path) {
  for (const fs::path& folder : {path, path / "cams"}) {
    if (!FilesEndingIn(folder, kMvsNetEnding).empty()) return folder;
  }
  return {};
}

}  // namespace

bool IsDtu(const fs::path& path) { return !DtuFiles(path).empty(); }

PosedScene ReadDtu(const fs::path& path, const fs::path& images) {
  PosedScene posed;
  posed.file = path;
  const std::vector<fs::path> folders = PhotographFolders(path, images);
  std::vector<fs::path> photographs;
  std::vector<Eigen::Matrix<double, 3, 4>> projections;
  for (const fs::path& file : DtuFiles(path)) {
    TextLines lines(file);
    projections.push_back(lines.Rows<3, 4>("P"));
    PosedImage& view = posed.images.emplace_back();
    view.image_path = PhotographOfNumber(DtuNumber(file), file, folders);
    view.name = view.image_path.filename().string();
    photographs.push_back(view.image_path);
  }
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  for (size_t i = 0; i < sizes.size(); ++i) {
    posed.images[i].camera =
        CameraOfProjection(projections[i], sizes[i], path, "P of " + posed.images[i].name);
  }
  return posed;
}

bool IsMvsNet(const fs::path& path) { return !MvsNetFolder(path).empty(); }

PosedScene ReadMvsNet(const fs::path& path, const fs::path& images) {
  const fs::path folder = MvsNetFolder(path);
  const std::vector<fs::path> folders = PhotographFolders(folder, images);
  PosedScene posed;
  posed.file = folder;
  std::vector<fs::path> photographs;
  for (const fs::path& file : FilesEndingIn(folder, kMvsNetEnding)) {
    TextLines lines(file);
    ExpectWord(&lines, "extrinsic");
    const Eigen::Matrix4d extrinsic = lines.Rows<4, 4>("extrinsic");
    if (extrinsic.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      lines.Fail("extrinsic", "its last row must be 0 0 0 1");
    }
    ExpectWord(&lines, "intrinsic");
    PosedImage& view = posed.images.emplace_back();
    view.camera = CameraOfIntrinsics(lines.Rows<3, 3>("intrinsic"), 0.5, file, "intrinsic");
    view.camera.rotation = NearestRotation(extrinsic.topLeftCorner<3, 3>(), file, "extrinsic");
    view.camera.translation = extrinsic.topRightCorner<3, 1>();
    const std::string name = file.filename().string();
    const std::string number = name.substr(0, name.size() - std::string(kMvsNetEnding).size());
    std::error_code error;
    for (const fs::path& where : folders) {
      for (const char* extension : {".jpg", ".png", ".jpeg", ".JPG", ".PNG", ".JPEG"}) {
        if (view.image_path.empty() && fs::exists(where / (number + extension), error)) {
          view.image_path = where / (number + extension);
        }
      }
    }
    if (view.image_path.empty()) {
      throw InputError(file, "there is no photograph " + number +
                                 ".jpg or .png; --images DIR says where they are");
    }
    view.name = view.image_path.filename().string();
    photographs.push_back(view.image_path);
  }
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  bool of_dtu = !sizes.empty();
  for (size_t i = 0; i < sizes.size(); ++i) {
    posed.images[i].camera.width = sizes[i].width;
    posed.images[i].camera.height = sizes[i].height;
    of_dtu = of_dtu && IsOfDtu(posed.images[i].camera);
  }
  if (!of_dtu) return posed;
  for (PosedImage& image : posed.images) {
    image.camera.cx += 0.5;
    image.camera.cy += 0.5;
  }
  posed.notes.push_back(
      "these cameras are DTU's, whose pixel centres are at whole numbers: half a pixel is added to "
      "principal points, as for pos_NNN.txt");
  return posed;
}

}  // namespace burin
