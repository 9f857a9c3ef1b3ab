#include "core/scene/formats/bundler.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <system_error>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/text_lines.h"
#include "core/scene/formats/view_names.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

const std::string kBundleEnding = ".bundle.out";

fs::path BundleFile(const fs::path& path) {
  return FileOrInFolder(path, ".out", {"bundle.out", "bundle/bundle.out"});
}

fs::path ListFile(const fs::path& bundle) {
  const fs::path folder = bundle.parent_path();
  const std::string name = bundle.filename().string();
  // NAME.bundle.out has NAME.list.txt, NAME.out has NAME.out.list.txt (COLMAP), or list.txt (Bundler).
  std::vector<fs::path> lists = {folder / (name + ".list.txt")};
  if (EndsIn(name, kBundleEnding)) {
    lists.push_back(folder / (name.substr(0, name.size() - kBundleEnding.size()) + ".list.txt"));
  }
  lists.push_back(folder / "list.txt");
  lists.push_back(folder / ".." / "list.txt");
  std::string looked;
  for (const fs::path& list : lists) {
    std::error_code error;
    if (fs::is_regular_file(list, error)) return list;
    looked += (looked.empty() ? "" : ", ") + list.string();
  }
  throw InputError(bundle, "the list with the names of the photographs is missing: none of " +
                               looked + " is there");
}

// A line of list.txt is NAME or NAME 0 FOCAL; names may have blanks.
std::string WithoutFocalLength(const std::string& line) {
  constexpr char kBlank[] = " \t\r";
  const size_t focal = line.find_last_of(kBlank);
  if (focal == std::string::npos) return line;
  char* end = nullptr;
  std::strtod(line.c_str() + focal + 1, &end);
  const size_t zero = line.find_last_not_of(kBlank, focal);
  if (*end != '\0' || zero == std::string::npos || zero == 0 || line[zero] != '0') return line;
  const size_t name = line.find_last_not_of(kBlank, zero - 1);
  return name == std::string::npos || name + 1 == zero ? line : line.substr(0, name + 1);
}

std::vector<std::string> ReadNames(const fs::path& path) {
  TextLines lines(path);
  std::vector<std::string> names;
  while (lines.NextElement()) {
    std::string& name = names.emplace_back(lines.Rest("image name"));
    name = WithoutFocalLength(name);
    std::replace(name.begin(), name.end(), '\\', '/');
  }
  return names;
}

void NextLine(TextLines* lines, const char* field) {
  if (!lines->NextElement()) lines->Fail(field, "the file ends");
}

// In the middle of a line or at the start of the next.
template <typename T>
T NextNumber(TextLines* lines, const char* field) {
  while (lines->AtEndOfLine()) NextLine(lines, field);
  return lines->Number<T>(field);
}

}  // namespace

bool IsBundler(const fs::path& path) { return !BundleFile(path).empty(); }

PosedScene ReadBundler(const fs::path& path, const fs::path& images) {
  const fs::path file = BundleFile(path);
  const fs::path list = ListFile(file);
  const std::vector<std::string> names = ReadNames(list);
  TextLines lines(file);
  NextLine(&lines, "number of cameras");
  const auto cameras = lines.Number<uint32_t>("number of cameras");
  const auto points = lines.Number<uint32_t>("number of points");
  lines.ExpectEndOfLine();
  if (cameras != names.size()) {
    throw InputError(list, "has " + std::to_string(names.size()) + " names, but " +
                               file.filename().string() + " has " + std::to_string(cameras) +
                               " cameras");
  }
  PosedScene posed;
  posed.file = file;
  std::vector<int> index(cameras, -1);
  std::vector<fs::path> photographs;
  const Eigen::DiagonalMatrix<double, 3> turn(1, -1, -1);
  for (uint32_t c = 0; c < cameras; ++c) {
    const Eigen::Vector3d lens = lines.Rows<1, 3>("f, k1, k2").transpose();
    const Eigen::Matrix3d rotation = lines.Rows<3, 3>("R");
    const Eigen::Vector3d translation = lines.Rows<1, 3>("t").transpose();
    if (lens[0] == 0) continue;
    index[c] = static_cast<int>(posed.images.size());
    PosedImage& view = posed.images.emplace_back();
    view.name = names[c];
    view.image_path = images.empty()
                          ? FindPhotograph(view.name, {list.parent_path(), file.parent_path()})
                          : FindPhotographBelow(view.name, images);
    photographs.push_back(view.image_path);
    view.camera.fx = view.camera.fy = lens[0];
    view.lens.brown = {lens[1], lens[2], 0, 0, 0};
    view.camera.rotation =
        turn * NearestRotation(rotation, file, "camera " + std::to_string(c) + ": R");
    view.camera.translation = turn * translation;
  }
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  for (size_t i = 0; i < sizes.size(); ++i) {
    Camera& camera = posed.images[i].camera;
    camera.width = sizes[i].width;
    camera.height = sizes[i].height;
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
  }
  for (uint32_t p = 0; p < points; ++p) {
    ScenePoint& point = posed.points.emplace_back();
    for (int k = 0; k < 3; ++k) point.position[k] = NextNumber<double>(&lines, "point position");
    for (int k = 0; k < 3; ++k) NextNumber<double>(&lines, "point colour");
    posed.tracks.BeginPoint();
    const auto views = NextNumber<uint32_t>(&lines, "number of views");
    for (uint32_t v = 0; v < views; ++v) {
      const auto camera = NextNumber<uint32_t>(&lines, "view: camera");
      if (camera >= cameras) {
        lines.Fail("view: camera", std::to_string(camera) + " does not exist");
      }
      Measurement measured;
      measured.view = index[camera];
      measured.keypoint = NextNumber<uint32_t>(&lines, "view: key");
      // From the middle of the picture, y up.
      const auto x = NextNumber<double>(&lines, "view: x");
      const auto y = NextNumber<double>(&lines, "view: y");
      if (measured.view < 0) continue;
      const Camera& seen_by = posed.images[measured.view].camera;
      measured.image_point = {seen_by.cx + x, seen_by.cy - y};
      point.views.push_back(measured.view);
      posed.tracks.Add(measured);
    }
  }
  return posed;
}

}  // namespace burin
