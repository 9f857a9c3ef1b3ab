#include "core/scene/formats/opensfm.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unordered_map>
#include <vector>

#include "core/scene/formats/json_values.h"
#include "core/scene/formats/text_lines.h"
#include "core/scene/formats/view_names.h"
#include "core/support/error.h"
#include "core/support/json_file.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Sides of photograph and file differ by less, as shares of the longer side, when they are of one shape.
constexpr double kSameShape = 2e-3;

fs::path ReconstructionFile(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return path.extension() == ".json" && HasJsonKey(path, "shots") ? path : fs::path();
  }
  const fs::path file = path / "reconstruction.json";
  return fs::is_regular_file(file, error) ? file : fs::path();
}

const json& Largest(const json& root) {
  if (!root.is_array()) return root;
  const json* largest = &root.at(0);
  for (const json& each : root) {
    if (each.at("shots").size() > largest->at("shots").size()) largest = &each;
  }
  return *largest;
}

struct NormalisedCamera {
  std::string type;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // shares of the longer side, from the middle
  double width = 0, height = 0;           // of the photographs, up to scale
  Lens lens;
};

NormalisedCamera CameraOf(const json& camera) {
  NormalisedCamera read;
  read.type = camera.value("projection_type", std::string("perspective"));
  read.width = NumberOr(camera, "width", 0);
  read.height = NumberOr(camera, "height", 0);
  read.fx = NumberOr(camera, "focal_x", NumberOr(camera, "focal", 0));
  read.fy = NumberOr(camera, "focal_y", read.fx);
  read.cx = NumberOr(camera, "c_x", 0);
  read.cy = NumberOr(camera, "c_y", 0);
  read.lens.brown = {NumberOr(camera, "k1", 0), NumberOr(camera, "k2", 0),
                     NumberOr(camera, "p1", 0), NumberOr(camera, "p2", 0),
                     NumberOr(camera, "k3", 0)};
  return read;
}

bool IsSupported(const std::string& type) {
  return type == "perspective" || type == "simple_radial" || type == "radial" || type == "brown";
}

bool HasShapeOf(const NormalisedCamera& camera, cv::Size photograph) {
  if (camera.width <= 0 || camera.height <= 0) return true;
  const double longer = std::max(camera.width, camera.height);
  const double side = std::max(photograph.width, photograph.height);
  return std::abs(camera.width / longer - photograph.width / side) < kSameShape &&
         std::abs(camera.height / longer - photograph.height / side) < kSameShape;
}

Eigen::Matrix3d RotationOf(const Eigen::Vector3d& angle_axis) {
  const double angle = angle_axis.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, angle_axis / angle).toRotationMatrix();
}

void AddPoints(const json& points, PosedScene* posed,
               std::unordered_map<std::string, size_t>* index_of_point) {
  for (const auto& [key, value] : points.items()) {
    ScenePoint& point = posed->points.emplace_back();
    point.position = Vector3(value.at("coordinates"));
    index_of_point->emplace(key, index_of_point->size());
  }
}

// tracks.csv: image, track, feature, x, y and more, with tabs between. Lines of a track come in any order.
void AddTracks(const fs::path& file, const std::map<std::string, int>& index_of_shot,
               const std::unordered_map<std::string, size_t>& index_of_point, PosedScene* posed) {
  std::vector<std::vector<Measurement>> of_point(posed->points.size());
  TextLines lines(file);
  while (lines.NextElement()) {
    const std::string image(lines.WordUntil('\t'));
    if (image.rfind("OPENSFM_TRACKS_VERSION", 0) == 0) continue;
    const std::string track(lines.Word("track"));
    Measurement measured;
    measured.keypoint = lines.Number<std::uint32_t>("feature");
    measured.image_point.x() = lines.Number<double>("x");
    measured.image_point.y() = lines.Number<double>("y");
    const auto shot = index_of_shot.find(image);
    const auto point = index_of_point.find(track);
    if (shot == index_of_shot.end() || point == index_of_point.end()) continue;
    measured.view = shot->second;
    const Camera& camera = posed->images[measured.view].camera;
    measured.image_point = measured.image_point * std::max(camera.width, camera.height) +
                           Eigen::Vector2d(camera.width, camera.height) / 2;
    of_point[point->second].push_back(measured);
  }
  for (size_t p = 0; p < of_point.size(); ++p) {
    posed->tracks.BeginPoint();
    for (const Measurement& measured : of_point[p]) {
      posed->points[p].views.push_back(measured.view);
      posed->tracks.Add(measured);
    }
  }
}

PosedScene FromJson(const json& root, const fs::path& file, const fs::path& images) {
  const json& reconstruction = Largest(root);
  const fs::path folder = file.parent_path();
  const std::vector<fs::path> places = {folder / "images", folder / ".." / "images", folder};
  PosedScene posed;
  posed.file = file;
  std::map<std::string, NormalisedCamera> cameras;
  for (const auto& [key, value] : reconstruction.at("cameras").items()) {
    cameras[key] = CameraOf(value);
  }
  std::vector<fs::path> paths;
  std::vector<const json*> shots;
  std::map<std::string, int> index_of_shot;
  for (const auto& [name, shot] : reconstruction.at("shots").items()) {
    index_of_shot[name] = static_cast<int>(posed.images.size());
    PosedImage& view = posed.images.emplace_back();
    view.name = name;
    view.image_path =
        images.empty() ? FindPhotograph(name, places) : FindPhotographBelow(name, images);
    paths.push_back(view.image_path);
    shots.push_back(&shot);
  }
  const std::vector<cv::Size> sizes = PhotographSizes(paths);
  for (size_t i = 0; i < sizes.size(); ++i) {
    PosedImage& view = posed.images[i];
    const std::string element = "shot " + view.name + ": ";
    const auto found = cameras.find(shots[i]->at("camera").get<std::string>());
    if (found == cameras.end()) throw InputError(file, element + "its camera is missing");
    const NormalisedCamera& given = found->second;
    if (!IsSupported(given.type)) {
      throw InputError(file, element + "projection_type '" + given.type + "' is not supported");
    }
    if (!HasShapeOf(given, sizes[i])) {
      throw InputError(view.image_path, "image size: is " + std::to_string(sizes[i].width) + " x " +
                                            std::to_string(sizes[i].height) +
                                            ", not of the shape of its camera " + found->first);
    }
    const double side = std::max(sizes[i].width, sizes[i].height);
    view.camera.width = sizes[i].width;
    view.camera.height = sizes[i].height;
    view.camera.fx = given.fx * side;
    view.camera.fy = given.fy * side;
    view.camera.cx = sizes[i].width / 2.0 + given.cx * side;
    view.camera.cy = sizes[i].height / 2.0 + given.cy * side;
    view.camera.rotation = RotationOf(Vector3(shots[i]->at("rotation")));
    view.camera.translation = Vector3(shots[i]->at("translation"));
    view.lens = given.lens;
    view.camera_id = std::distance(cameras.begin(), found);
    view.camera_model = given.type;
  }
  std::unordered_map<std::string, size_t> index_of_point;
  if (reconstruction.contains("points")) {
    AddPoints(reconstruction["points"], &posed, &index_of_point);
  }
  std::error_code error;
  const fs::path tracks = folder / "tracks.csv";
  if (fs::is_regular_file(tracks, error)) {
    AddTracks(tracks, index_of_shot, index_of_point, &posed);
  } else if (!posed.points.empty()) {
    posed.notes.push_back("tracks.csv is not beside " + file.filename().string() +
                          ": which shots see its points is not known, they are left out");
  }
  if (root.is_array() && root.size() > 1) {
    posed.notes.push_back("the largest of " + std::to_string(root.size()) +
                          " reconstructions is read, with " + std::to_string(posed.images.size()) +
                          " shots");
  }
  return posed;
}

}  // namespace

bool IsOpenSfm(const fs::path& path) { return !ReconstructionFile(path).empty(); }

PosedScene ReadOpenSfm(const fs::path& path, const fs::path& images) {
  const fs::path file = ReconstructionFile(path);
  const json root = ReadJsonFile(file);
  try {
    return FromJson(root, file, images);
  } catch (const json::exception& error) {
    throw InputError(file, std::string("is not as OpenSfM writes it: ") + error.what());
  } catch (const std::out_of_range& error) {
    throw InputError(file, std::string("is not as OpenSfM writes it: ") + error.what());
  }
}

}  // namespace burin
