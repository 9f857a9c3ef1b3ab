#include "core/formats/openmvg.h"

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "core/formats/camera_checks.h"
#include "core/json_file.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Intrinsic {
  std::string type;
  Camera camera;
  Lens lens;
};

Eigen::Vector3d Vector3(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

bool IsSupported(const std::string& type) {
  return type == "pinhole" || type == "pinhole_radial_k1" || type == "pinhole_radial_k3" ||
         type == "pinhole_brown_t2";
}

// cereal writes the name of a type once, with the top bit of its number set, and the number after that.
std::map<uint32_t, Intrinsic> ReadIntrinsics(const json& list) {
  std::map<uint32_t, std::string> name_of_type;
  std::map<uint32_t, Intrinsic> intrinsics;
  for (const json& entry : list) {
    const json& value = entry.at("value");
    const uint32_t type = value.at("polymorphic_id").get<uint32_t>() & 0x7fffffffU;
    if (value.contains("polymorphic_name")) name_of_type[type] = value["polymorphic_name"];
    Intrinsic& intrinsic = intrinsics[entry.at("key").get<uint32_t>()];
    intrinsic.type = name_of_type[type];
    if (!IsSupported(intrinsic.type)) continue;
    const json& data = value.at("ptr_wrapper").at("data");
    Camera& camera = intrinsic.camera;
    camera.width = data.at("width").get<int>();
    camera.height = data.at("height").get<int>();
    camera.fx = camera.fy = data.at("focal_length").get<double>();
    camera.cx = data.at("principal_point").at(0).get<double>() + 0.5;
    camera.cy = data.at("principal_point").at(1).get<double>() + 0.5;
    std::array<double, 5>& brown = intrinsic.lens.brown;
    if (data.contains("disto_k1")) brown[0] = data["disto_k1"].at(0).get<double>();
    for (const char* field : {"disto_k3", "disto_t2"}) {
      if (!data.contains(field)) continue;
      brown[0] = data[field].at(0).get<double>();
      brown[1] = data[field].at(1).get<double>();
      brown[4] = data[field].at(2).get<double>();
    }
    if (data.contains("disto_t2")) {
      brown[2] = data["disto_t2"].at(3).get<double>();
      brown[3] = data["disto_t2"].at(4).get<double>();
    }
  }
  return intrinsics;
}

PosedScene FromJson(const json& root, const fs::path& path, const fs::path& images) {
  const std::map<uint32_t, Intrinsic> intrinsics = ReadIntrinsics(root.at("intrinsics"));
  std::map<uint32_t, const json*> poses;
  for (const json& entry : root.at("extrinsics")) {
    poses[entry.at("key").get<uint32_t>()] = &entry.at("value");
  }
  PosedScene posed;
  posed.file = path;
  const fs::path stated = root.at("root_path").get<std::string>();
  std::map<uint32_t, int> index_of_view;
  for (const json& entry : root.at("views")) {
    const json& data = entry.at("value").at("ptr_wrapper").at("data");
    const auto pose = poses.find(data.at("id_pose").get<uint32_t>());
    const auto intrinsic = intrinsics.find(data.at("id_intrinsic").get<uint32_t>());
    if (pose == poses.end() || intrinsic == intrinsics.end()) continue;
    const fs::path name =
        fs::path(data.value("local_path", std::string())) / data.at("filename").get<std::string>();
    const std::string element = "view " + name.string() + ": ";
    if (!IsSupported(intrinsic->second.type)) {
      throw InputError(
          path, element + "intrinsics of type '" + intrinsic->second.type + "' are not supported");
    }
    index_of_view[entry.at("key").get<uint32_t>()] = static_cast<int>(posed.images.size());
    PosedImage& view = posed.images.emplace_back();
    view.name = name.lexically_normal().relative_path().string();
    view.image_path =
        images.empty()
            ? FindPhotograph(view.name, {path.parent_path() / stated, path.parent_path()})
            : FindPhotograph(view.name, {images});
    view.camera = intrinsic->second.camera;
    view.lens = intrinsic->second.lens;
    Eigen::Matrix3d rotation;
    for (int r = 0; r < 3; ++r) {
      rotation.row(r) = Vector3(pose->second->at("rotation").at(r)).transpose();
    }
    view.camera.rotation = NearestRotation(rotation, path, element + "rotation");
    view.camera.translation = -view.camera.rotation * Vector3(pose->second->at("center"));
  }
  if (!root.contains("structure")) return posed;
  for (const json& entry : root["structure"]) {
    ScenePoint& point = posed.points.emplace_back();
    point.position = Vector3(entry.at("value").at("X"));
    for (const json& seen : entry.at("value").at("observations")) {
      const auto view = index_of_view.find(seen.at("key").get<uint32_t>());
      if (view != index_of_view.end()) point.views.push_back(view->second);
    }
  }
  return posed;
}

}  // namespace

bool IsOpenMvg(const fs::path& path) { return path.extension() == ".json"; }

PosedScene ReadOpenMvg(const fs::path& path, const fs::path& images) {
  const json root = ReadJsonFile(path);
  if (!root.is_object() || !root.contains("sfm_data_version")) {
    throw InputError(path, "sfm_data_version: is missing, this is no openMVG scene");
  }
  try {
    return FromJson(root, path, images);
  } catch (const json::exception& error) {
    throw InputError(path, std::string("is not as openMVG writes it: ") + error.what());
  }
}

}  // namespace burin
