// Text form of a COLMAP model: one line per element (two per image); '#' opens a comment line.
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/scene/formats/colmap_model.h"
#include "core/scene/formats/text_lines.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

std::vector<ColmapCamera> ReadCameras(const std::filesystem::path& path) {
  std::vector<ColmapCamera> cameras;
  TextLines lines(path);
  while (lines.NextElement()) {
    ColmapCamera& camera = cameras.emplace_back();
    camera.id = lines.Number<std::uint32_t>("CAMERA_ID");
    camera.model = FindCameraModel(std::string(lines.Word("MODEL")), camera.id, path);
    camera.width = lines.Number<std::uint64_t>("WIDTH");
    camera.height = lines.Number<std::uint64_t>("HEIGHT");
    for (int i = 0; i < camera.model->ParameterCount(); ++i) {
      camera.parameters.push_back(lines.Number<double>("PARAMS"));
    }
    lines.ExpectEndOfLine();
  }
  return cameras;
}

// Of no point for -1 and whatever else is no number of a point.
std::uint64_t PointId(std::string_view word) {
  std::uint64_t id = kNoId;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), id);
  return result.ptr == word.data() + word.size() ? id : kNoId;
}

std::vector<ColmapImage> ReadImages(const std::filesystem::path& path) {
  std::vector<ColmapImage> images;
  TextLines lines(path);
  while (lines.NextElement()) {
    ColmapImage& image = images.emplace_back();
    image.id = lines.Number<std::uint32_t>("IMAGE_ID");
    image.quaternion[0] = lines.Number<double>("QW");
    image.quaternion.tail<3>() = lines.Vector3("QX", "QY", "QZ");
    image.translation = lines.Vector3("TX", "TY", "TZ");
    image.camera_id = lines.Number<std::uint32_t>("CAMERA_ID");
    image.name = lines.Rest("NAME");
    // The observations have a line of their own, blank when there are none; editors drop a blank
    // one at the end of the file.
    if (!lines.Next()) break;
    while (!lines.AtEndOfLine()) {
      ColmapObservation& observation = image.observations.emplace_back();
      observation.image_point.x() = lines.Number<double>("POINTS2D X");
      observation.image_point.y() = lines.Number<double>("POINTS2D Y");
      observation.point_id = PointId(lines.Word("POINTS2D POINT3D_ID"));
    }
  }
  return images;
}

std::vector<ColmapPoint> ReadPoints(const std::filesystem::path& path) {
  std::vector<ColmapPoint> points;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return points;
  TextLines lines(path);
  while (lines.NextElement()) {
    ColmapPoint& point = points.emplace_back();
    point.id = lines.Number<std::uint64_t>("POINT3D_ID");
    point.position = lines.Point("X", "Y", "Z");
    for (const char* channel : {"R", "G", "B"}) lines.Number<std::uint8_t>(channel);
    lines.Word("ERROR");
    while (!lines.AtEndOfLine()) {
      ColmapTrackElement& seen = point.track.emplace_back();
      seen.image_id = lines.Number<std::uint32_t>("TRACK IMAGE_ID");
      seen.observation = lines.Number<std::uint32_t>("TRACK POINT2D_IDX");
    }
  }
  return points;
}

// " value" in the shortest form that reads back to the same bits.
void Append(double value, std::string* text) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  text->push_back(' ');
  text->append(buffer, result.ptr);
}

void Append(std::uint64_t value, std::string* text) { *text += " " + std::to_string(value); }

}  // namespace

ColmapModel ReadColmapText(const ColmapFiles& files) {
  return {ReadCameras(files.cameras), ReadImages(files.images), ReadPoints(files.points)};
}

void WriteColmapText(const ColmapModel& model, const ColmapFiles& files) {
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (const ColmapCamera& camera : model.cameras) {
    text += std::to_string(camera.id) + " " + camera.model->name;
    Append(camera.width, &text);
    Append(camera.height, &text);
    for (const double parameter : camera.parameters) Append(parameter, &text);
    text += "\n";
  }
  WriteTextAtomically(files.cameras, text);

  text =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n"
      "# POINTS2D[] as X Y POINT3D_ID\n";
  for (const ColmapImage& image : model.images) {
    text += std::to_string(image.id);
    for (int i = 0; i < 4; ++i) Append(image.quaternion[i], &text);
    for (int i = 0; i < 3; ++i) Append(image.translation[i], &text);
    Append(std::uint64_t{image.camera_id}, &text);
    text += " " + image.name + "\n";
    std::string line;
    for (const ColmapObservation& observation : image.observations) {
      Append(observation.image_point.x(), &line);
      Append(observation.image_point.y(), &line);
      Append(observation.point_id, &line);
    }
    text += (line.empty() ? line : line.substr(1)) + "\n";
  }
  WriteTextAtomically(files.images, text);

  text = "# POINT3D_ID X Y Z R G B ERROR TRACK[] as IMAGE_ID POINT2D_IDX\n";
  for (const ColmapPoint& point : model.points) {
    text += std::to_string(point.id);
    for (int i = 0; i < 3; ++i) Append(point.position[i], &text);
    for (int channel = 0; channel < 3; ++channel) Append(std::uint64_t{point.gray}, &text);
    Append(point.error, &text);
    for (const ColmapTrackElement& seen : point.track) {
      Append(std::uint64_t{seen.image_id}, &text);
      Append(std::uint64_t{seen.observation}, &text);
    }
    text += "\n";
  }
  WriteTextAtomically(files.points, text);
}

}  // namespace burin
