#include "core/scene/formats/transforms.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
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

constexpr double kDegree = 3.14159265358979323846 / 180;

fs::path TransformsFile(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return path.extension() == ".json" && HasJsonKey(path, "frames") ? path : fs::path();
  }
  for (const char* name : {"transforms.json", "transforms_train.json"}) {
    if (fs::is_regular_file(path / name, error)) return path / name;
  }
  return {};
}

// What a frame says, else what the file says for all.
class Fields {
 public:
  Fields(const json& frame, const json& root) : frame_(frame), root_(root) {}

  const json* Find(const char* key) const {
    for (const json* object : {&frame_, &root_}) {
      const auto found = object->find(key);
      if (found != object->end() && !found->is_null()) return &*found;
    }
    return nullptr;
  }
  double Number(const char* key, double otherwise) const {
    const json* value = Find(key);
    return value == nullptr ? otherwise : value->get<double>();
  }
  bool IsTrue(const char* key) const {
    const json* value = Find(key);
    return value != nullptr && value->is_boolean() && value->get<bool>();
  }
  // fl_x, or from the angle of view of `side` pixels; 0 where none is given.
  double Focal(const std::string& axis, double side) const {
    const double focal = Number(("fl_" + axis).c_str(), 0);
    const double angle =
        Number(("camera_angle_" + axis).c_str(), kDegree * Number((axis + "_fov").c_str(), 0));
    return focal != 0 || angle == 0 ? focal : side / 2 / std::tan(angle / 2);
  }

 private:
  const json& frame_;
  const json& root_;
};

void RefuseOtherLenses(const Fields& fields, const fs::path& file, const std::string& element) {
  const json* model = fields.Find("camera_model");
  if (model != nullptr) {
    const std::string name = model->get<std::string>();
    const std::vector<std::string> brown = {"OPENCV", "PINHOLE",       "SIMPLE_PINHOLE",
                                            "RADIAL", "SIMPLE_RADIAL", "PERSPECTIVE"};
    if (std::find(brown.begin(), brown.end(), name) == brown.end()) {
      throw InputError(file, element + "camera_model '" + name + "' is not supported");
    }
  }
  for (const char* other : {"is_fisheye", "latlong", "equirectangular"}) {
    if (fields.IsTrue(other)) throw InputError(file, element + other + " is not supported");
  }
  for (const char* other : {"k4", "ftheta_p0", "distortion_params"}) {
    const json* value = fields.Find(other);
    if (value != nullptr && *value != json(0)) {
      throw InputError(file, element + other + " is not supported");
    }
  }
}

// Some write whole numbers as 800.0.
int Side(const Fields& fields, const char* key, int photograph, const fs::path& file,
         const std::string& element) {
  const double side = fields.Number(key, photograph);
  if (!(side >= 1 && side <= 1e9) || side != std::floor(side)) {
    throw InputError(file, element + key + " = " + fields.Find(key)->dump() +
                               ": must be a whole number of pixels");
  }
  return static_cast<int>(side);
}

Camera CameraOf(const Fields& fields, cv::Size photograph, const fs::path& file,
                const std::string& element) {
  Camera camera;
  camera.width = Side(fields, "w", photograph.width, file, element);
  camera.height = Side(fields, "h", photograph.height, file, element);
  camera.fx = fields.Focal("x", camera.width);
  camera.fy = fields.Focal("y", camera.height);
  if (camera.fx == 0 && camera.fy == 0) {
    throw InputError(file, element + "fl_x: is missing, and so is camera_angle_x");
  }
  if (camera.fy == 0) camera.fy = camera.fx;
  if (camera.fx == 0) camera.fx = camera.fy;
  camera.cx = fields.Number("cx", camera.width / 2.0);
  camera.cy = fields.Number("cy", camera.height / 2.0);
  return camera;
}

void SetPose(const json& matrix, const fs::path& file, const std::string& element, Camera* camera) {
  Eigen::Matrix3d world_from_camera;
  Eigen::Vector3d center;
  for (int r = 0; r < 3; ++r) {
    world_from_camera.row(r) = Vector3(matrix.at(r)).transpose();
    center[r] = matrix.at(r).at(3).get<double>();
  }
  if (matrix.size() > 3) {
    const Eigen::RowVector4d last(matrix[3].at(0), matrix[3].at(1), matrix[3].at(2),
                                  matrix[3].at(3));
    if ((last - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-6) {
      throw InputError(file, element + "transform_matrix: its last row must be 0 0 0 1");
    }
  }
  world_from_camera.col(1) = -world_from_camera.col(1);
  world_from_camera.col(2) = -world_from_camera.col(2);
  camera->rotation =
      NearestRotation(world_from_camera.transpose(), file, element + "transform_matrix");
  camera->translation = -camera->rotation * center;
}

// The frames whose photographs are there. instant-ngp takes frames out by taking their photographs away.
std::vector<const json*> AddPhotographs(const json& frames, const fs::path& file,
                                        const fs::path& images, PosedScene* posed) {
  std::vector<const json*> kept;
  std::string first_missing;
  std::string first_error;
  for (const json& frame : frames) {
    std::string name = frame.at("file_path").get<std::string>();
    std::replace(name.begin(), name.end(), '\\', '/');
    name = images.empty()
               ? WithExtension(name, {file.parent_path() / name})
               : WithExtension(name, {images / name, images / fs::path(name).filename()});
    try {
      const fs::path path = images.empty() ? FindPhotograph(name, {file.parent_path()})
                                           : FindPhotographBelow(name, images);
      posed->images.emplace_back().image_path = path;
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
      if (first_missing.empty()) first_missing = name;
      continue;
    }
    PosedImage& view = posed->images.back();
    view.name = name;
    const auto mask = frame.find("mask_path");
    if (mask != frame.end() && !mask->is_null()) {
      view.mask_path = file.parent_path() / mask->get<std::string>();
    }
    kept.push_back(&frame);
  }
  if (kept.size() == frames.size()) return kept;
  if (kept.size() < 2) throw InputError(first_error);
  posed->notes.push_back(
      std::to_string(frames.size() - kept.size()) + " of " + std::to_string(frames.size()) +
      " frames left out: their photographs are missing; the first is " + first_missing);
  return kept;
}

PosedScene FromJson(const json& root, const fs::path& file, const fs::path& images) {
  PosedScene posed;
  posed.file = file;
  const std::vector<const json*> frames = AddPhotographs(root.at("frames"), file, images, &posed);
  std::vector<fs::path> paths;
  for (const PosedImage& view : posed.images) paths.push_back(view.image_path);
  const std::vector<cv::Size> sizes = PhotographSizes(paths);
  for (size_t i = 0; i < sizes.size(); ++i) {
    const Fields fields(*frames[i], root);
    PosedImage& view = posed.images[i];
    const std::string element = "frame " + view.name + ": ";
    RefuseOtherLenses(fields, file, element);
    view.camera = CameraOf(fields, sizes[i], file, element);
    view.lens.brown = {fields.Number("k1", 0), fields.Number("k2", 0), fields.Number("p1", 0),
                       fields.Number("p2", 0), fields.Number("k3", 0)};
    const json* model = fields.Find("camera_model");
    if (model != nullptr) view.camera_model = model->get<std::string>();
    SetPose(frames[i]->at("transform_matrix"), file, element, &view.camera);
  }
  return posed;
}

}  // namespace

bool IsTransforms(const fs::path& path) { return !TransformsFile(path).empty(); }

PosedScene ReadTransforms(const fs::path& path, const fs::path& images) {
  const fs::path file = TransformsFile(path);
  const json root = ReadJsonFile(file);
  try {
    return FromJson(root, file, images);
  } catch (const json::exception& error) {
    throw InputError(file, std::string("is no transforms.json as it should be: ") + error.what());
  } catch (const std::out_of_range& error) {
    throw InputError(file, std::string("is no transforms.json as it should be: ") + error.what());
  }
}

}  // namespace burin
