#include "core/scene/formats/metashape.h"

#include <Eigen/Core>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/view_names.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

fs::path CamerasFile(const fs::path& path) { return FileOrInFolder(path, ".xml", {"cameras.xml"}); }

std::vector<double> Numbers(const pugi::xml_node& node, size_t count, const fs::path& file,
                            const std::string& element) {
  std::vector<double> numbers;
  std::string_view text = node.text().get();
  constexpr std::string_view kBlank = " \t\r\n";
  for (size_t at = text.find_first_not_of(kBlank); at != std::string_view::npos;
       at = text.find_first_not_of(kBlank)) {
    text.remove_prefix(at);
    const std::string_view word = text.substr(0, text.find_first_of(kBlank));
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) {
      throw InputError(file,
                       element + node.name() + ": '" + std::string(word) + "' is not a number");
    }
    numbers.push_back(number);
    text.remove_prefix(word.size());
  }
  if (numbers.size() != count) {
    throw InputError(file, element + node.name() + ": has " + std::to_string(numbers.size()) +
                               " numbers, must have " + std::to_string(count));
  }
  return numbers;
}

// What a calibration without the field means is 0.
double Parameter(const pugi::xml_node& calibration, const char* name, const fs::path& file,
                 const std::string& element) {
  const pugi::xml_node node = calibration.child(name);
  return node ? Numbers(node, 1, file, element)[0] : 0;
}

// world_from_chunk.
struct ChunkPlace {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1;
};

ChunkPlace PlaceOf(const pugi::xml_node& transform, const fs::path& file,
                   const std::string& element) {
  ChunkPlace place;
  if (const pugi::xml_node node = transform.child("rotation")) {
    const std::vector<double> numbers = Numbers(node, 9, file, element);
    for (int k = 0; k < 9; ++k) place.rotation(k / 3, k % 3) = numbers[k];
    place.rotation = NearestRotation(place.rotation, file, element + "rotation");
  }
  if (const pugi::xml_node node = transform.child("translation")) {
    place.translation = Eigen::Vector3d(Numbers(node, 3, file, element).data());
  }
  if (const pugi::xml_node node = transform.child("scale")) {
    place.scale = Numbers(node, 1, file, element)[0];
    if (!(place.scale > 0)) throw InputError(file, element + "scale: must be above 0");
  }
  return place;
}

void SetSensor(const pugi::xml_node& sensor, const fs::path& file, const std::string& element,
               PosedImage* view) {
  const std::string type = sensor.attribute("type").as_string("frame");
  if (type != "frame")
    throw InputError(file, element + "sensor of type '" + type + "' is not supported");
  pugi::xml_node calibration = sensor.find_child_by_attribute("calibration", "class", "adjusted");
  if (!calibration) calibration = sensor.child("calibration");
  if (!calibration.child("f"))
    throw InputError(file, element + "its sensor has no calibration with f");
  const pugi::xml_node size = calibration.child("resolution") ? calibration.child("resolution")
                                                              : sensor.child("resolution");
  const auto value = [&](const char* name) { return Parameter(calibration, name, file, element); };
  for (const char* name : {"k4", "p3", "p4", "b2"}) {
    if (value(name) != 0) {
      throw InputError(file, element + name + " = " + calibration.child(name).text().get() +
                                 " is not supported: undistort the photographs first");
    }
  }
  Camera& camera = view->camera;
  camera.width = size.attribute("width").as_int();
  camera.height = size.attribute("height").as_int();
  camera.fx = value("f") + value("b1");
  camera.fy = value("f");
  camera.cx = camera.width / 2.0 + value("cx");
  camera.cy = camera.height / 2.0 + value("cy");
  view->lens.brown = {value("k1"), value("k2"), value("p2"), value("p1"), value("k3")};
}

void SetPose(const pugi::xml_node& transform, const ChunkPlace& place, const fs::path& file,
             const std::string& element, Camera* camera) {
  const std::vector<double> numbers = Numbers(transform, 16, file, element);
  Eigen::Matrix3d chunk_from_camera;
  Eigen::Vector3d center;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) chunk_from_camera(r, c) = numbers[4 * r + c];
    center[r] = numbers[4 * r + 3];
  }
  const Eigen::Matrix3d rotation =
      NearestRotation(chunk_from_camera.transpose(), file, element + "transform");
  camera->rotation = rotation * place.rotation.transpose();
  camera->translation =
      -camera->rotation * (place.scale * (place.rotation * center) + place.translation);
}

bool IsOfTheEarth(const pugi::xml_node& chunk) {
  const std::string_view reference = chunk.child("reference").text().get();
  return !reference.empty() && reference.find("LOCAL_CS") == std::string_view::npos;
}

}  // namespace

bool IsMetashape(const fs::path& path) { return !CamerasFile(path).empty(); }

PosedScene ReadMetashape(const fs::path& path, const fs::path& images) {
  const fs::path file = CamerasFile(path);
  const std::string bytes = ReadFileBytes(file);
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(bytes.data(), bytes.size());
  if (!result) {
    throw InputError(
        file, "byte " + std::to_string(result.offset) + ": not valid XML: " + result.description());
  }
  const pugi::xml_node chunk = document.child("document").child("chunk");
  if (!chunk)
    throw InputError(file, "document/chunk: is missing, these are no cameras of Metashape");
  const bool of_the_earth = IsOfTheEarth(chunk);
  std::map<std::string, ChunkPlace> places;
  const ChunkPlace chunks =
      of_the_earth ? ChunkPlace() : PlaceOf(chunk.child("transform"), file, "chunk: ");
  if (!of_the_earth) {
    for (const pugi::xml_node& component : chunk.child("components").children("component")) {
      const std::string id = component.attribute("id").as_string();
      if (const pugi::xml_node transform = component.child("transform")) {
        places[id] = PlaceOf(transform, file, "component " + id + ": ");
      }
    }
  }
  PosedScene posed;
  posed.file = file;
  size_t all = 0;
  std::map<std::string, std::uint64_t> sensor_index;
  std::string first_without;
  const fs::path beside = file.parent_path();
  for (const pugi::xpath_node& found : chunk.select_nodes("cameras//camera")) {
    const pugi::xml_node camera = found.node();
    std::string label = camera.attribute("label").as_string();
    ++all;
    if (!camera.child("transform") || !camera.attribute("enabled").as_bool(true)) {
      if (first_without.empty()) first_without = label;
      continue;
    }
    const std::string element = "camera " + label + ": ";
    const pugi::xml_node sensor = chunk.child("sensors").find_child_by_attribute(
        "sensor", "id", camera.attribute("sensor_id").as_string());
    if (!sensor) throw InputError(file, element + "its sensor is missing");
    const std::string last = fs::path(label).filename().string();
    PosedImage& view = posed.images.emplace_back();
    if (images.empty()) {
      view.name = WithExtension(last, {beside / "images" / last, beside / last});
      view.image_path = FindPhotograph(view.name, {beside / "images", beside});
    } else {
      view.name = WithExtension(label, {images / label, images / last});
      view.image_path = FindPhotographBelow(view.name, images);
    }
    view.camera_id =
        sensor_index.emplace(camera.attribute("sensor_id").as_string(), sensor_index.size())
            .first->second;
    SetSensor(sensor, file, element, &view);
    const auto place = places.find(camera.attribute("component_id").as_string());
    SetPose(camera.child("transform"), place == places.end() ? chunks : place->second, file,
            element, &view.camera);
  }
  if (posed.images.empty()) {
    throw InputError(file, std::to_string(all) + " cameras, none is aligned");
  }
  if (posed.images.size() < all) {
    posed.notes.push_back(std::to_string(all - posed.images.size()) + " of " + std::to_string(all) +
                          " cameras left out: they are not aligned or disabled; the first is " +
                          first_without);
  }
  if (of_the_earth) {
    posed.notes.push_back(
        "cameras are georeferenced: the scene is in the chunk's own frame, in which its mesh must "
        "be "
        "too (Metashape: export it in local coordinates, without a reference)");
  }
  return posed;
}

}  // namespace burin
