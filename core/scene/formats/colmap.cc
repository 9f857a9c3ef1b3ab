#include "core/scene/formats/colmap.h"

#include <algorithm>
#include <array>
#include <map>
#include <system_error>

#include "core/scene/formats/colmap_model.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

void RequireFolder(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) throw InputError(folder, "folder is missing");
  if (!fs::is_directory(folder, error)) throw InputError(folder, "is not a folder");
}

// The models that a workspace may have, in the order in which they count.
std::array<ColmapFiles, 4> CandidatesIn(const fs::path& workspace) {
  const fs::path sparse = workspace / "sparse";
  return {ColmapFilesIn(sparse, true), ColmapFilesIn(sparse, false),
          ColmapFilesIn(sparse / "0", true), ColmapFilesIn(sparse / "0", false)};
}

// Whether the folder has a model itself, as sparse/0 of a workspace has.
bool IsModel(const fs::path& folder) {
  for (const bool binary : {true, false}) {
    const ColmapFiles files = ColmapFilesIn(folder, binary);
    std::error_code error;
    if (fs::exists(files.cameras, error) && fs::exists(files.images, error)) return true;
  }
  return false;
}

bool HasSparse(const fs::path& path) {
  std::error_code error;
  return fs::exists(path / "sparse", error);
}

// images/ of the workspace: of a model's folder images/ in it or in one of the two above.
fs::path ImagesOf(const fs::path& path) {
  if (!HasSparse(path)) {
    for (const char* above : {".", "..", "../.."}) {
      const fs::path images = (path / above / "images").lexically_normal();
      std::error_code error;
      if (fs::is_directory(images, error)) return images;
    }
  }
  return path / "images";
}

// The first complete model; else the first that lacks its points; else the files of the first incomplete one, for the error of the reader
// to name what is missing.
ColmapFiles FindModel(const fs::path& workspace) {
  if (!HasSparse(workspace) && IsModel(workspace)) {
    const ColmapFiles binary = ColmapFilesIn(workspace, true);
    std::error_code error;
    return fs::exists(binary.cameras, error) ? binary : ColmapFilesIn(workspace, false);
  }
  const fs::path sparse = workspace / "sparse";
  RequireFolder(sparse);
  const ColmapFiles* incomplete = nullptr;
  const ColmapFiles* without_points = nullptr;
  const std::array<ColmapFiles, 4> candidates = CandidatesIn(workspace);
  for (const ColmapFiles& files : candidates) {
    std::error_code error;
    const bool cameras = fs::exists(files.cameras, error);
    const bool images = fs::exists(files.images, error);
    const bool points = fs::exists(files.points, error);
    if (cameras && images && points) return files;
    if (cameras && images && without_points == nullptr) without_points = &files;
    if ((cameras || images || points) && incomplete == nullptr) incomplete = &files;
  }
  if (without_points != nullptr) return *without_points;
  if (incomplete == nullptr) {
    throw InputError(sparse,
                     "no model: cameras, images and points3D (.bin or .txt) are neither here nor "
                     "in 0/");
  }
  return *incomplete;
}

Camera PinholeOf(const ColmapCamera& camera, const ColmapImage& image) {
  const int focal_count = camera.model->focal_count;
  Camera pinhole;
  pinhole.width = static_cast<int>(camera.width);
  pinhole.height = static_cast<int>(camera.height);
  pinhole.fx = camera.parameters[0];
  pinhole.fy = camera.parameters[focal_count - 1];
  pinhole.cx = camera.parameters[focal_count];
  pinhole.cy = camera.parameters[focal_count + 1];
  const Eigen::Vector4d q = image.quaternion.stableNormalized();
  pinhole.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  pinhole.translation = image.translation;
  return pinhole;
}

Lens LensOf(const ColmapCamera& camera) {
  Lens lens;
  std::copy(camera.parameters.begin() + camera.model->focal_count + 2, camera.parameters.end(),
            lens.brown.begin());
  return lens;
}

// Where the image has the point, if it has.
const ColmapObservation* ObservationOf(const ColmapImage& image, std::uint32_t index,
                                       std::uint64_t point_id) {
  if (index >= image.observations.size()) return nullptr;
  const ColmapObservation& observation = image.observations[index];
  return observation.point_id == point_id ? &observation : nullptr;
}

// Who sees what is taken from the points' tracks. Exporters of known poses write these without
// observations in the images, or with such as have nothing to do with them.
void AddPoints(const ColmapModel& model, const std::map<std::uint32_t, int>& index_of_image,
               PosedScene* posed) {
  int absent = 0;
  std::string first;
  for (const ColmapPoint& point : model.points) {
    ScenePoint& scene_point = posed->points.emplace_back();
    scene_point.position = point.position;
    scene_point.id = point.id;
    posed->tracks.BeginPoint();
    for (const ColmapTrackElement& seen : point.track) {
      const auto found = index_of_image.find(seen.image_id);
      if (found == index_of_image.end()) {
        if (++absent == 1) {
          first = "IMAGE_ID = " + std::to_string(seen.image_id) + " of point " +
                  std::to_string(point.id);
        }
        continue;
      }
      const int image = found->second;
      scene_point.views.push_back(image);
      const ColmapObservation* observation =
          ObservationOf(model.images[image], seen.observation, point.id);
      if (observation == nullptr) continue;
      posed->tracks.Add({observation->image_point, image, seen.observation});
    }
  }
  if (absent > 0) {
    posed->notes.push_back(std::to_string(absent) +
                           " views of sparse points left out: the model has no such image; the "
                           "first is " +
                           first);
  }
}

}  // namespace

bool IsColmap(const fs::path& path) { return HasSparse(path) || IsModel(path); }

std::vector<fs::path> ColmapModelFiles(const fs::path& workspace) {
  std::vector<fs::path> names;
  for (const ColmapFiles& files : CandidatesIn(workspace)) {
    names.insert(names.end(), {files.cameras, files.images, files.points});
  }
  return names;
}

PosedScene ReadColmap(const fs::path& workspace, const fs::path& images) {
  const ColmapFiles files = FindModel(workspace);
  ColmapModel model = files.binary ? ReadColmapBinary(files) : ReadColmapText(files);
  CheckColmapModel(model, files);
  std::sort(model.points.begin(), model.points.end(),
            [](const ColmapPoint& a, const ColmapPoint& b) { return a.id < b.id; });
  std::map<std::uint32_t, const ColmapCamera*> camera_of_id;
  for (const ColmapCamera& camera : model.cameras) camera_of_id[camera.id] = &camera;
  PosedScene posed;
  posed.file = files.images;
  posed.images_folder = images.empty() ? ImagesOf(workspace) : images;
  std::map<std::uint32_t, int> index_of_image;
  for (const ColmapImage& image : model.images) {
    index_of_image[image.id] = static_cast<int>(posed.images.size());
    const ColmapCamera& camera = *camera_of_id.at(image.camera_id);
    PosedImage& view = posed.images.emplace_back();
    view.name = image.name;
    view.image_path = posed.images_folder / image.name;
    view.camera = PinholeOf(camera, image);
    view.lens = LensOf(camera);
    view.camera_name = "camera " + std::to_string(camera.id);
    view.image_id = image.id;
    view.camera_id = camera.id;
    view.camera_model = camera.model->name;
  }
  std::error_code error;
  if (!fs::exists(files.points, error)) {
    posed.notes.push_back(files.points.string() + ": is missing: the scene has no sparse points");
  }
  AddPoints(model, index_of_image, &posed);
  return posed;
}

}  // namespace burin
