#include "core/scene/formats/meshroom.h"

#include <Eigen/Core>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/json_values.h"
#include "core/scene/formats/view_names.h"
#include "core/support/error.h"
#include "core/support/json_file.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

using Version = std::array<int, 3>;

constexpr double kSensorWidth = 36;  // millimetres, where none is said

fs::path CamerasFile(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    return fs::is_regular_file(path / "cameras.sfm", error) ? path / "cameras.sfm" : fs::path();
  }
  if (path.extension() == ".sfm") return path;
  return path.extension() == ".json" && HasJsonKey(path, "poses") ? path : fs::path();
}

double Number(const json& value) {
  if (!value.is_string()) return value.get<double>();
  const std::string text = value.get<std::string>();
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) {
    throw std::out_of_range("'" + text + "' is not a number");
  }
  return number;
}

double Number(const json& object, const char* key, double otherwise) {
  return object.contains(key) ? Number(object[key]) : otherwise;
}

int Pixels(const json& value) {
  const double pixels = Number(value);
  if (!(pixels >= 1 && pixels <= 1e9)) throw std::out_of_range(value.dump() + " is no size");
  return static_cast<int>(pixels);
}

// Identifiers are numbers, written as strings or not.
std::string Id(const json& object, const char* key) {
  const json& value = object.at(key);
  return value.is_string() ? value.get<std::string>() : value.dump();
}

Version VersionOf(const json& root) {
  Version version = {1, 0, 0};
  for (size_t k = 0; root.contains("version") && k < 3 && k < root["version"].size(); ++k) {
    const double number = Number(root["version"].at(k));
    version[k] = number >= 0 && number < 1e6 ? static_cast<int>(number) : 0;
  }
  return version;
}

struct Intrinsic {
  std::string type;
  bool is_supported = false;
  Camera camera;
  Lens lens;
};

void SetFocal(const json& value, const Version& version, Camera* camera) {
  if (version < Version{1, 2, 0}) {
    camera->fx = camera->fy = Number(value.at("pxFocalLength"));
  } else if (version < Version{1, 2, 2}) {
    camera->fx = Number(value.at("pxFocalLength").at(0));
    camera->fy = Number(value.at("pxFocalLength").at(1));
  } else {
    const double ratio = Number(value, "pixelRatio", 1);
    camera->fx = Number(value.at("focalLength")) / Number(value, "sensorWidth", kSensorWidth) *
                 camera->width;
    camera->fy = version < Version{1, 2, 5} ? camera->fx / ratio : camera->fx * ratio;
  }
}

Intrinsic IntrinsicOf(const json& value, const Version& version) {
  Intrinsic intrinsic;
  intrinsic.type = value.at("type").get<std::string>();
  std::string lens = intrinsic.type == "pinhole" ? "none" : intrinsic.type;
  if (intrinsic.type == "pinhole" && value.contains("distortionType")) {
    lens = value["distortionType"].get<std::string>();
    if (lens != "none") intrinsic.type += " " + lens;
  }
  std::vector<double> parameters;
  if (value.contains("distortionParams") && value["distortionParams"].is_array()) {
    for (const json& parameter : value["distortionParams"]) parameters.push_back(Number(parameter));
  }
  parameters.resize(5);
  std::array<double, 5>& brown = intrinsic.lens.brown;
  if (lens == "radial1" || lens == "radialk1") {
    brown[0] = parameters[0];
  } else if (lens == "radial3" || lens == "radialk3") {
    brown = {parameters[0], parameters[1], 0, 0, parameters[2]};
  } else if (lens == "brown") {
    brown = {parameters[0], parameters[1], parameters[3], parameters[4], parameters[2]};
  } else if (lens != "none") {
    return intrinsic;
  }
  intrinsic.is_supported = true;
  Camera& camera = intrinsic.camera;
  camera.width = Pixels(value.at("width"));
  camera.height = Pixels(value.at("height"));
  SetFocal(value, version, &camera);
  const bool from_middle = !(version < Version{1, 2, 1});
  camera.cx =
      Number(value.at("principalPoint").at(0)) + (from_middle ? camera.width / 2.0 : 0) + 0.5;
  camera.cy =
      Number(value.at("principalPoint").at(1)) + (from_middle ? camera.height / 2.0 : 0) + 0.5;
  return intrinsic;
}

fs::path PhotographOf(const std::string& name, const fs::path& file, const fs::path& images) {
  if (!images.empty()) return FindPhotographBelow(name, images);
  const fs::path beside = file.parent_path();
  std::error_code error;
  if (fs::is_regular_file(beside / name, error)) return beside / name;
  return FindPhotograph(fs::path(name).filename().string(), {beside, beside / "images"});
}

void SetPose(const json& transform, const fs::path& file, const std::string& element,
             Camera* camera) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d center;
  for (int k = 0; k < 9; ++k) rotation(k % 3, k / 3) = Number(transform.at("rotation").at(k));
  for (int k = 0; k < 3; ++k) center[k] = Number(transform.at("center").at(k));
  camera->rotation = NearestRotation(rotation, file, element + "rotation");
  camera->translation = -camera->rotation * center;
}

void AddPoints(const json& structure, const std::map<std::string, int>& index_of_view,
               PosedScene* posed) {
  for (const json& landmark : structure) {
    ScenePoint& point = posed->points.emplace_back();
    for (int k = 0; k < 3; ++k) point.position[k] = Number(landmark.at("X").at(k));
    posed->tracks.BeginPoint();
    if (!landmark.contains("observations") || !landmark["observations"].is_array()) continue;
    for (const json& observation : landmark["observations"]) {
      const auto view = index_of_view.find(Id(observation, "observationId"));
      if (view == index_of_view.end()) continue;
      point.views.push_back(view->second);
      if (!observation.contains("x")) continue;
      Measurement measured;
      measured.view = view->second;
      measured.image_point = {Number(observation["x"].at(0)) + 0.5,
                              Number(observation["x"].at(1)) + 0.5};
      posed->tracks.Add(measured);
    }
  }
}

PosedScene FromJson(const json& root, const fs::path& file, const fs::path& images) {
  const Version version = VersionOf(root);
  std::map<std::string, Intrinsic> intrinsics;
  if (root.contains("intrinsics")) {
    for (const json& value : root["intrinsics"]) {
      intrinsics[Id(value, "intrinsicId")] = IntrinsicOf(value, version);
    }
  }
  std::map<std::string, const json*> poses;
  if (root.contains("poses")) {
    for (const json& value : root["poses"]) {
      poses[Id(value, "poseId")] = &value.at("pose").at("transform");
    }
  }
  PosedScene posed;
  posed.file = file;
  std::map<std::string, int> index_of_view;
  std::string first_without;
  for (const json& value : root.at("views")) {
    const std::string name = value.at("path").get<std::string>();
    const std::string element = "view " + name + ": ";
    const auto pose = value.contains("poseId") ? poses.find(Id(value, "poseId")) : poses.end();
    const auto intrinsic = value.contains("intrinsicId") ? intrinsics.find(Id(value, "intrinsicId"))
                                                         : intrinsics.end();
    if (pose == poses.end() || intrinsic == intrinsics.end()) {
      if (first_without.empty()) first_without = name;
      continue;
    }
    if (value.contains("rigId")) throw InputError(file, element + "rigs are not supported");
    if (!intrinsic->second.is_supported) {
      throw InputError(
          file, element + "intrinsics of type '" + intrinsic->second.type + "' are not supported");
    }
    index_of_view[Id(value, "viewId")] = static_cast<int>(posed.images.size());
    PosedImage& view = posed.images.emplace_back();
    view.name = name;
    view.image_path = PhotographOf(name, file, images);
    view.camera = intrinsic->second.camera;
    view.lens = intrinsic->second.lens;
    view.camera_id = std::distance(intrinsics.begin(), intrinsic);
    view.camera_model = intrinsic->second.type;
    SetPose(*pose->second, file, element, &view.camera);
  }
  const size_t all = root.at("views").size();
  if (posed.images.empty()) {
    throw InputError(file, std::to_string(all) +
                               " views, none has a pose: take the file that StructureFromMotion "
                               "writes");
  }
  if (posed.images.size() < all) {
    posed.notes.push_back(std::to_string(all - posed.images.size()) + " of " + std::to_string(all) +
                          " views left out: they have no pose or no intrinsics; the first is " +
                          first_without);
  }
  if (root.contains("structure") && root["structure"].is_array()) {
    AddPoints(root["structure"], index_of_view, &posed);
  }
  return posed;
}

}  // namespace

bool IsMeshroom(const fs::path& path) { return !CamerasFile(path).empty(); }

PosedScene ReadMeshroom(const fs::path& path, const fs::path& images) {
  const fs::path file = CamerasFile(path);
  const json root = ReadJsonFile(file);
  try {
    return FromJson(root, file, images);
  } catch (const json::exception& error) {
    throw InputError(file, std::string("is not as Meshroom writes it: ") + error.what());
  } catch (const std::out_of_range& error) {
    throw InputError(file, std::string("is not as Meshroom writes it: ") + error.what());
  }
}

}  // namespace burin
