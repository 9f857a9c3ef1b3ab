#include "core/scene/formats/nvm.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <vector>

#include "core/scene/formats/text_lines.h"
#include "core/scene/formats/view_names.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

void NextLine(TextLines* lines, const char* field) {
  if (!lines->NextElement()) lines->Fail(field, "the file ends");
}

struct FixedCalibration {
  bool given = false;
  double fx = 0, cx = 0, fy = 0, cy = 0, radial = 0;
};

FixedCalibration ReadHeader(TextLines* lines) {
  NextLine(lines, "header");
  if (lines->Word("header") != "NVM_V3") lines->Fail("header", "must be NVM_V3");
  FixedCalibration fixed;
  if (lines->AtEndOfLine()) return fixed;
  if (lines->Word("calibration") != "FixedK") lines->Fail("calibration", "must be FixedK");
  fixed.given = true;
  fixed.fx = lines->Number<double>("fx");
  fixed.cx = lines->Number<double>("cx");
  fixed.fy = lines->Number<double>("fy");
  fixed.cy = lines->Number<double>("cy");
  if (!lines->AtEndOfLine()) fixed.radial = lines->Number<double>("r");
  lines->ExpectEndOfLine();
  return fixed;
}

PosedImage ReadCamera(TextLines* lines, const FixedCalibration& fixed) {
  PosedImage view;
  view.name = std::string(lines->Word("image name"));
  std::replace(view.name.begin(), view.name.end(), '"', ' ');
  std::replace(view.name.begin(), view.name.end(), '\\', '/');
  const auto focal = lines->Number<double>("focal length");
  Eigen::Vector4d q;
  for (int k = 0; k < 4; ++k) q[k] = lines->Number<double>("quaternion");
  const Eigen::Vector3d center = lines->Vector3("centre x", "centre y", "centre z");
  const auto radial = lines->Number<double>("radial distortion");
  lines->Number<double>("0");
  lines->ExpectEndOfLine();
  if (q.norm() < 1e-12) lines->Fail("quaternion", "cannot be normalised to a rotation");
  q.normalize();
  view.camera.fx = fixed.given ? fixed.fx : focal;
  view.camera.fy = fixed.given ? fixed.fy : focal;
  view.camera.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  view.camera.translation = -view.camera.rotation * center;
  view.lens.measured = fixed.given ? fixed.radial : radial;
  return view;
}

std::vector<Eigen::Vector2d> PrincipalPoints(const std::vector<PosedImage>& images) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(images.size());
  for (const PosedImage& image : images) points.emplace_back(image.camera.cx, image.camera.cy);
  return points;
}

}  // namespace

bool IsNvm(const fs::path& path) { return path.extension() == ".nvm"; }

PosedScene ReadNvm(const fs::path& path, const fs::path& images) {
  TextLines lines(path);
  const FixedCalibration fixed = ReadHeader(&lines);
  NextLine(&lines, "number of cameras");
  const auto cameras = lines.Number<uint32_t>("number of cameras");
  PosedScene posed;
  posed.file = path;
  std::vector<fs::path> photographs;
  for (uint32_t c = 0; c < cameras; ++c) {
    NextLine(&lines, "camera");
    PosedImage view = ReadCamera(&lines, fixed);
    if (images.empty()) {
      view.image_path = FindPhotograph(view.name, {path.parent_path()});
    } else {
      view.image_path = FindPhotographBelow(view.name, images);
    }
    photographs.push_back(view.image_path);
    posed.images.push_back(std::move(view));
  }
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  for (size_t i = 0; i < sizes.size(); ++i) {
    Camera& camera = posed.images[i].camera;
    camera.width = sizes[i].width;
    camera.height = sizes[i].height;
    camera.cx = fixed.given ? fixed.cx + 0.5 : 0.5 * camera.width;
    camera.cy = fixed.given ? fixed.cy + 0.5 : 0.5 * camera.height;
  }
  NextLine(&lines, "number of points");
  const auto points = lines.Number<uint32_t>("number of points");
  lines.ExpectEndOfLine();
  bool from_corner = true;
  for (uint32_t p = 0; p < points; ++p) {
    NextLine(&lines, "point");
    ScenePoint& point = posed.points.emplace_back();
    point.position = lines.Point("x", "y", "z");
    for (int k = 0; k < 3; ++k) lines.Number<double>("colour");
    posed.tracks.BeginPoint();
    const auto views = lines.Number<uint32_t>("number of views");
    for (uint32_t v = 0; v < views; ++v) {
      const auto camera = lines.Number<uint32_t>("view: camera");
      if (camera >= cameras) {
        lines.Fail("view: camera", std::to_string(camera) + " does not exist");
      }
      Measurement measured;
      measured.view = static_cast<int>(camera);
      measured.keypoint = lines.Number<uint32_t>("view: feature");
      measured.image_point.x() = lines.Number<double>("view: x");
      measured.image_point.y() = lines.Number<double>("view: y");
      from_corner = from_corner && measured.image_point.minCoeff() >= 0;
      point.views.push_back(measured.view);
      posed.tracks.Add(measured);
    }
    lines.ExpectEndOfLine();
  }
  // VisualSFM counts from the principal point, COLMAP, when it writes this format, from the corner.
  if (!from_corner) posed.tracks.Shift(PrincipalPoints(posed.images));
  return posed;
}

}  // namespace burin
