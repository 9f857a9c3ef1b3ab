// A COLMAP sparse model as its files hold it (cameras, images, points3D; text or binary), before it
// becomes a Scene. This header is for readers and writers of COLMAP. The rest of burin calls
// core/scene/formats/colmap.h.
//
// COLMAP's conventions are burin's: image coordinates in pixels with the centre of the top-left
// pixel at (0.5, 0.5); the pose of an image is cam_from_world, camera axes x right, y down,
// z forward.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace burin {

// A camera model that burin reads. Its parameters are focal_count focal lengths (f, or fx and fy),
// cx, cy, then distortion_count coefficients in OpenCV's order k1, k2, p1, p2.
struct ColmapCameraModel {
  int id;
  const char* name;
  int focal_count;
  int distortion_count;
  int ParameterCount() const { return focal_count + 2 + distortion_count; }
};

struct ColmapCamera {
  std::uint32_t id = 0;
  const ColmapCameraModel* model = nullptr;  // an entry of the table of supported models
  std::uint64_t width = 0, height = 0;       // pixels
  std::vector<double> parameters;            // model->ParameterCount() of them
};

struct ColmapObservation {
  Eigen::Vector2d image_point;  // pixels
  std::uint64_t point_id = kNoId;
};

struct ColmapImage {
  std::uint32_t id = 0;
  Eigen::Vector4d quaternion;   // w, x, y, z of cam_from_world; any length but zero
  Eigen::Vector3d translation;  // of cam_from_world, world units
  std::uint32_t camera_id = 0;
  std::string name;  // path below images/
  std::vector<ColmapObservation> observations;
};

struct ColmapTrackElement {
  std::uint32_t image_id = 0;
  std::uint32_t observation = 0;  // index into that image's observations
};

struct ColmapPoint {
  std::uint64_t id = 0;
  Eigen::Vector3d position;  // world units
  std::uint8_t gray = 0;     // written as the point's colour; not read
  double error =
      0;  // written, not read: mean distance from its projections to where it was measured, px
  std::vector<ColmapTrackElement> track;
};

struct ColmapModel {
  std::vector<ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
};

// The three files of a model.
struct ColmapFiles {
  std::filesystem::path cameras, images, points;
  bool binary = false;
};

// The files of a text (.txt) or binary (.bin) model in `folder`, existing or not.
ColmapFiles ColmapFilesIn(const std::filesystem::path& folder, bool binary);

// Whether FindCameraModel() has one of that name.
bool IsColmapCameraModel(const std::string& name);

// The supported model of that name or number. Throws InputError naming file, camera, model and what
// is supported.
const ColmapCameraModel* FindCameraModel(const std::string& name, std::uint32_t camera_id,
                                         const std::filesystem::path& cameras_file);
const ColmapCameraModel* FindCameraModel(int model_id, std::uint32_t camera_id,
                                         const std::filesystem::path& cameras_file);

// colmap_text.cc and colmap_binary.cc. Reading throws InputError for what is missing,
// truncated or malformed; a text file's message has the line number. No count in a file is trusted
// before it has been compared with the length of the file. Writing is atomic file by file, with
// the same bytes for the same model; text keeps every bit of every number.
ColmapModel ReadColmapText(const ColmapFiles& files);
ColmapModel ReadColmapBinary(const ColmapFiles& files);
void WriteColmapText(const ColmapModel& model, const ColmapFiles& files);
void WriteColmapBinary(const ColmapModel& model, const ColmapFiles& files);

// What has to hold whichever format the model came from: sizes and focal lengths positive, numbers
// finite, quaternions of non-zero length, ids and names unique, references resolvable, at least two
// images. Throws InputError naming file, element and field.
void CheckColmapModel(const ColmapModel& model, const ColmapFiles& files);

}  // namespace burin
