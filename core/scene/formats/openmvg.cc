#include "core/scene/formats/openmvg.h"

#include <Eigen/Core>
#include <cstdint>
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

struct Intrinsic {
  std::string type;
  Camera camera;
  Lens lens;
};

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
    const uint32_t type = Whole<uint32_t>(value.at("polymorphic_id")) & 0x7fffffffU;
    if (value.contains("polymorphic_name")) name_of_type[type] = value["polymorphic_name"];
    Intrinsic& intrinsic = intrinsics[Whole<uint32_t>(entry.at("key"))];
    intrinsic.type = name_of_type[type];
    if (!IsSupported(intrinsic.type)) continue;
    const json& data = value.at("ptr_wrapper").at("data");
    // v1.1 to v1.6 have the fields of the base class of some types one level down.
    const json& base = data.contains("value0") ? data["value0"] : data;
    Camera& camera = intrinsic.camera;
    camera.width = Whole<int>(base.at("width"));
    camera.height = Whole<int>(base.at("height"));
    camera.fx = camera.fy = base.at("focal_length").get<double>();
    camera.cx = base.at("principal_point").at(0).get<double>() + 0.5;
    camera.cy = base.at("principal_point").at(1).get<double>() + 0.5;
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

// Where an observation of the structure is, if it says so.
void AddMeasurement(const json& observation, int view, Tracks* tracks) {
  if (!observation.contains("value") || !observation["value"].contains("x")) return;
  const json& value = observation["value"];
  Measurement measured;
  measured.view = view;
  measured.image_point = {value["x"].at(0).get<double>() + 0.5,
                          value["x"].at(1).get<double>() + 0.5};
  if (value.contains("id_feat")) measured.keypoint = Whole<uint32_t>(value["id_feat"]);
  tracks->Add(measured);
}

PosedScene FromJson(const json& root, const fs::path& path, const fs::path& images) {
  const std::map<uint32_t, Intrinsic> intrinsics = ReadIntrinsics(root.at("intrinsics"));
  std::map<uint32_t, const json*> poses;
  for (const json& entry : root.at("extrinsics")) {
    poses[Whole<uint32_t>(entry.at("key"))] = &entry.at("value");
  }
  PosedScene posed;
  posed.file = path;
  const fs::path stated = root.at("root_path").get<std::string>();
  std::map<uint32_t, int> index_of_view;
  std::string first_without;
  for (const json& entry : root.at("views")) {
    const json& data = entry.at("value").at("ptr_wrapper").at("data");
    const auto pose = poses.find(Whole<uint32_t>(data.at("id_pose")));
    const auto intrinsic = intrinsics.find(Whole<uint32_t>(data.at("id_intrinsic")));
    const fs::path name =
        fs::path(data.value("local_path", std::string())) / data.at("filename").get<std::string>();
    if (pose == poses.end() || intrinsic == intrinsics.end()) {
      if (first_without.empty()) first_without = name.string();
      continue;
    }
    const std::string element = "view " + name.string() + ": ";
    if (!IsSupported(intrinsic->second.type)) {
      throw InputError(
          path, element + "intrinsics of type '" + intrinsic->second.type + "' are not supported");
    }
    index_of_view[Whole<uint32_t>(entry.at("key"))] = static_cast<int>(posed.images.size());
    PosedImage& view = posed.images.emplace_back();
    view.name = name.relative_path().string();
    view.image_path =
        images.empty()
            ? FindPhotograph(view.name, {path.parent_path() / stated, path.parent_path()})
            : FindPhotographBelow(view.name, images);
    view.camera = intrinsic->second.camera;
    view.lens = intrinsic->second.lens;
    view.image_id = Whole<uint32_t>(entry.at("key"));
    view.camera_id = intrinsic->first;
    view.camera_model = intrinsic->second.type;
    Eigen::Matrix3d rotation;
    for (int r = 0; r < 3; ++r) {
      rotation.row(r) = Vector3(pose->second->at("rotation").at(r)).transpose();
    }
    view.camera.rotation = NearestRotation(rotation, path, element + "rotation");
    view.camera.translation = -view.camera.rotation * Vector3(pose->second->at("center"));
  }
  if (posed.images.empty()) {
    throw InputError(path, std::to_string(root.at("views").size()) +
                               " views, none has a pose: this is the listing of the photographs; "
                               "take the reconstruction's sfm_data, as JSON");
  }
  if (posed.images.size() < root.at("views").size()) {
    posed.notes.push_back(std::to_string(root.at("views").size() - posed.images.size()) + " of " +
                          std::to_string(root.at("views").size()) +
                          " views left out: they have no pose or no intrinsics; the first is " +
                          first_without);
  }
  if (!root.contains("structure")) return posed;
  for (const json& entry : root["structure"]) {
    ScenePoint& point = posed.points.emplace_back();
    point.position = Vector3(entry.at("value").at("X"));
    if (entry.contains("key")) point.id = Whole<uint32_t>(entry["key"]);
    posed.tracks.BeginPoint();
    for (const json& seen : entry.at("value").at("observations")) {
      const auto view = index_of_view.find(Whole<uint32_t>(seen.at("key")));
      if (view == index_of_view.end()) continue;
      point.views.push_back(view->second);
      AddMeasurement(seen, view->second, &posed.tracks);
    }
  }
  return posed;
}

}  // namespace

bool IsOpenMvg(const fs::path& path) { return path.extension() == ".json"; }

PosedScene ReadOpenMvg(const fs::path& path, const fs::path& images) {
  const json root = ReadJsonFile(path);
  if (!root.is_object() || !root.contains("sfm_data_version")) {
    throw InputError(
        path,
        "is no scene in JSON that burin knows: none of sfm_data_version (openMVG), frames "
        "(transforms.json), shots (OpenSfM) and poses (Meshroom) is there");
  }
  try {
    return FromJson(root, path, images);
  } catch (const json::exception& error) {
    throw InputError(path, std::string("is not as openMVG writes it: ") + error.what());
  } catch (const std::out_of_range& error) {
    throw InputError(path, std::string("is not as openMVG writes it: ") + error.what());
  }
}

}  // namespace burin
