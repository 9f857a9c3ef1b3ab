#include "core/scene/formats/colmap_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "core/support/error.h"

namespace burin {
namespace {

constexpr ColmapCameraModel kSupportedModels[] = {
    {0, "SIMPLE_PINHOLE", 1, 0}, {1, "PINHOLE", 2, 0}, {2, "SIMPLE_RADIAL", 1, 1},
    {3, "RADIAL", 1, 2},         {4, "OPENCV", 2, 4},
};

// All of COLMAP's models, for messages: the index is the number in a binary file.
constexpr const char* kModelNames[] = {
    "SIMPLE_PINHOLE",
    "PINHOLE",
    "SIMPLE_RADIAL",
    "RADIAL",
    "OPENCV",
    "OPENCV_FISHEYE",
    "FULL_OPENCV",
    "FOV",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
    "RAD_TAN_THIN_PRISM_FISHEYE",
    "SIMPLE_DIVISION",
    "DIVISION",
    "SIMPLE_FISHEYE",
    "FISHEYE",
};

[[noreturn]] void ThrowUnsupported(const std::string& name, std::uint32_t camera_id,
                                   const std::filesystem::path& file) {
  std::string supported;
  for (const ColmapCameraModel& model : kSupportedModels) {
    supported += (supported.empty() ? "" : ", ") + std::string(model.name);
  }
  throw InputError(file, "camera " + std::to_string(camera_id) + ": MODEL = " + name +
                             ": not supported; supported are " + supported +
                             " (undistort the images first)");
}

void CheckCamera(const ColmapCamera& camera, const std::filesystem::path& file) {
  const std::string element = "camera " + std::to_string(camera.id) + ": ";
  const auto fail = [&](const std::string& field, double value, const std::string& reason) {
    throw InputError(file, element + field + " = " + std::to_string(value) + ": " + reason);
  };
  const auto max_size = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  for (const bool is_width : {true, false}) {
    const std::uint64_t size = is_width ? camera.width : camera.height;
    if (size < 1 || size > max_size) {
      throw InputError(file, element + (is_width ? "WIDTH = " : "HEIGHT = ") +
                                 std::to_string(size) + ": must be between 1 and " +
                                 std::to_string(max_size) + " pixels");
    }
  }
  const int focal_count = camera.model->focal_count;
  for (int i = 0; i < camera.model->ParameterCount(); ++i) {
    const double value = camera.parameters[i];
    if (i < focal_count) {
      if (!std::isfinite(value) || value <= 0) {
        fail("focal length", value, "must be finite and above 0");
      }
    } else if (!std::isfinite(value)) {
      fail(i < focal_count + 2 ? "principal point" : "distortion coefficient", value,
           "must be finite");
    }
  }
}

void CheckImage(const ColmapImage& image, const std::filesystem::path& file) {
  const std::string element = "image " + std::to_string(image.id) + ": ";
  const double length = image.quaternion.stableNorm();
  if (!std::isfinite(length) || length < 1e-12) {
    throw InputError(file, element + "QW, QX, QY, QZ: length " + std::to_string(length) +
                               " cannot be normalised to a rotation");
  }
  if (!image.translation.allFinite()) {
    throw InputError(file, element + "TX, TY, TZ: must be finite");
  }
  if (image.name.empty()) throw InputError(file, element + "NAME: is empty");
  for (const unsigned char c : image.name) {
    if (c < 0x20 || c == 0x7f) {
      throw InputError(file, element + "NAME: contains the control character " + std::to_string(c));
    }
  }
}

}  // namespace

ColmapFiles ColmapFilesIn(const std::filesystem::path& folder, bool binary) {
  const std::string extension = binary ? ".bin" : ".txt";
  return {folder / ("cameras" + extension), folder / ("images" + extension),
          folder / ("points3D" + extension), binary};
}

bool IsColmapCameraModel(const std::string& name) {
  return std::any_of(std::begin(kSupportedModels), std::end(kSupportedModels),
                     [&](const ColmapCameraModel& model) { return name == model.name; });
}

const ColmapCameraModel* FindCameraModel(const std::string& name, std::uint32_t camera_id,
                                         const std::filesystem::path& cameras_file) {
  for (const ColmapCameraModel& model : kSupportedModels) {
    if (name == model.name) return &model;
  }
  ThrowUnsupported(name, camera_id, cameras_file);
}

const ColmapCameraModel* FindCameraModel(int model_id, std::uint32_t camera_id,
                                         const std::filesystem::path& cameras_file) {
  for (const ColmapCameraModel& model : kSupportedModels) {
    if (model_id == model.id) return &model;
  }
  const bool has_name = model_id >= 0 && model_id < static_cast<int>(std::size(kModelNames));
  ThrowUnsupported(has_name ? kModelNames[model_id] : "number " + std::to_string(model_id),
                   camera_id, cameras_file);
}

void CheckColmapModel(const ColmapModel& model, const ColmapFiles& files) {
  std::set<std::uint32_t> camera_ids;
  for (const ColmapCamera& camera : model.cameras) {
    CheckCamera(camera, files.cameras);
    if (!camera_ids.insert(camera.id).second) {
      throw InputError(files.cameras,
                       "camera " + std::to_string(camera.id) + ": CAMERA_ID appears twice");
    }
  }

  std::set<std::uint32_t> image_ids;
  std::set<std::string> names;
  for (const ColmapImage& image : model.images) {
    CheckImage(image, files.images);
    const std::string element = "image " + std::to_string(image.id) + ": ";
    if (!image_ids.insert(image.id).second) {
      throw InputError(files.images, element + "IMAGE_ID appears twice");
    }
    if (!names.insert(image.name).second) {
      throw InputError(files.images, element + "NAME = " + image.name + ": appears twice");
    }
    if (camera_ids.count(image.camera_id) == 0) {
      throw InputError(files.images, element + "CAMERA_ID = " + std::to_string(image.camera_id) +
                                         ": no such camera in " +
                                         files.cameras.filename().string());
    }
  }
  if (model.images.size() < 2) {
    throw InputError(files.images, "has " + std::to_string(model.images.size()) +
                                       " image(s): at least 2 are needed");
  }

  std::set<std::uint64_t> point_ids;
  for (const ColmapPoint& point : model.points) {
    const std::string element = "point " + std::to_string(point.id) + ": ";
    if (!point_ids.insert(point.id).second) {
      throw InputError(files.points, element + "POINT3D_ID appears twice");
    }
  }
}

}  // namespace burin
