#include "core/scene/formats/colmap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/image/gray_image.h"
#include "core/scene/formats/colmap_model.h"
#include "core/support/atomic_file.h"
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

// The first complete model; else the files of the first incomplete one, for the error of the reader
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
  const std::array<ColmapFiles, 4> candidates = CandidatesIn(workspace);
  for (const ColmapFiles& files : candidates) {
    int existing = 0;
    for (const fs::path* file : {&files.cameras, &files.images, &files.points}) {
      std::error_code error;
      if (fs::exists(*file, error)) ++existing;
    }
    if (existing == 3) return files;
    if (existing > 0 && incomplete == nullptr) incomplete = &files;
  }
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
  for (const ColmapPoint& point : model.points) {
    ScenePoint& scene_point = posed->points.emplace_back();
    scene_point.position = point.position;
    scene_point.id = point.id;
    posed->tracks.BeginPoint();
    for (const ColmapTrackElement& seen : point.track) {
      const int image = index_of_image.at(seen.image_id);
      scene_point.views.push_back(image);
      const ColmapObservation* observation =
          ObservationOf(model.images[image], seen.observation, point.id);
      if (observation == nullptr) continue;
      posed->tracks.Add({observation->image_point, image, seen.observation});
    }
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
  AddPoints(model, index_of_image, &posed);
  return posed;
}

namespace {

void CheckView(const View& view, const fs::path& images, std::set<std::string>* names) {
  const fs::path name = view.name;
  const bool leaves = name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end();
  if (leaves || name.filename().empty()) {
    throw InputError(images, "view name '" + view.name + "': must be a path inside this folder");
  }
  if (!names->insert(view.name).second) {
    throw InputError(images, "view name '" + view.name + "': appears twice");
  }
  WritableExtension(images / name);
  const bool is_gray = view.gray.type() == CV_8UC1 || view.gray.type() == CV_32FC1;
  if (view.gray.empty() || !is_gray || view.gray.cols != view.camera.width ||
      view.gray.rows != view.camera.height) {
    throw InputError(images / name, "image: must be 8-bit or float grey of the camera's size, " +
                                        std::to_string(view.camera.width) + " x " +
                                        std::to_string(view.camera.height));
  }
}

// Numbers that a model may have: theirs where all are given, distinct and in range, else 1, 2, ...
std::vector<std::uint64_t> Numbers(std::vector<std::uint64_t> ids, std::uint64_t most) {
  const bool in_range =
      std::all_of(ids.begin(), ids.end(), [&](std::uint64_t id) { return id >= 1 && id <= most; });
  if (!in_range || std::set<std::uint64_t>(ids.begin(), ids.end()).size() < ids.size()) {
    std::iota(ids.begin(), ids.end(), 1);
  }
  return ids;
}

constexpr std::uint64_t kMostId = std::numeric_limits<std::uint32_t>::max() - 1;

bool HaveOneCamera(const View& a, const View& b) {
  const auto values = [](const Camera& camera) {
    return std::make_tuple(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
  };
  return values(a.camera) == values(b.camera);
}

// The number of the camera of every view: views that shared one still do, unless a number is out of range or
// has cameras that differ; then every view has its own.
std::vector<std::uint64_t> CameraNumbers(const std::vector<View>& views) {
  std::vector<std::uint64_t> numbers;
  std::map<std::uint64_t, const View*> first_of;
  bool as_they_are = true;
  for (const View& view : views) {
    const std::uint64_t id = numbers.emplace_back(view.origin.camera_id);
    const View* first = first_of.emplace(id, &view).first->second;
    as_they_are = as_they_are && id >= 1 && id <= kMostId && HaveOneCamera(*first, view);
  }
  if (!as_they_are) std::iota(numbers.begin(), numbers.end(), 1);
  return numbers;
}

void AddViews(const std::vector<View>& views, const ColmapCameraModel* pinhole,
              ColmapModel* model) {
  std::vector<std::uint64_t> ids;
  ids.reserve(views.size());
  for (const View& view : views) ids.push_back(view.origin.image_id);
  ids = Numbers(std::move(ids), kMostId);
  const std::vector<std::uint64_t> camera_ids = CameraNumbers(views);
  std::set<std::uint64_t> written;
  for (size_t v = 0; v < views.size(); ++v) {
    const Camera& from = views[v].camera;
    if (written.insert(camera_ids[v]).second) {
      ColmapCamera& camera = model->cameras.emplace_back();
      camera.id = static_cast<std::uint32_t>(camera_ids[v]);
      camera.model = pinhole;
      camera.width = from.width;
      camera.height = from.height;
      camera.parameters = {from.fx, from.fy, from.cx, from.cy};
    }
    ColmapImage& image = model->images.emplace_back();
    image.id = static_cast<std::uint32_t>(ids[v]);
    image.camera_id = static_cast<std::uint32_t>(camera_ids[v]);
    image.name = views[v].name;
    image.translation = from.translation;
    Eigen::Quaterniond q(from.rotation);
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    image.quaternion = {q.w(), q.x(), q.y(), q.z()};
  }
}

// Grey level nearest to an image point; 0 outside the image.
std::uint8_t LevelAt(const View& view, const Eigen::Vector2d& image_point) {
  const double col = std::floor(image_point.x());
  const double row = std::floor(image_point.y());
  if (!(col >= 0 && row >= 0 && col < view.gray.cols && row < view.gray.rows)) return 0;
  const int i = static_cast<int>(row);
  const int j = static_cast<int>(col);
  return view.gray.type() == CV_8UC1 ? view.gray.at<std::uint8_t>(i, j)
                                     : cv::saturate_cast<std::uint8_t>(view.gray.at<float>(i, j));
}

void AddObservation(const View& view, const Eigen::Vector2d& image_point, ColmapImage* image,
                    ColmapPoint* point) {
  if (point->track.empty()) point->gray = LevelAt(view, image_point);
  point->track.push_back({image->id, static_cast<std::uint32_t>(image->observations.size())});
  image->observations.push_back({image_point, point->id});
}

// Where its views see a point: as measured; by projection where the scene has no measurements.
void AddObservations(const Scene& scene, size_t index, const ColmapFiles& files,
                     ColmapModel* model) {
  ColmapPoint& point = model->points[index];
  if (!scene.tracks.IsEmpty()) {
    for (const Measurement& measured : scene.tracks.Of(index)) {
      AddObservation(scene.views[measured.view], measured.image_point,
                     &model->images[measured.view], &point);
    }
    return;
  }
  for (const int v : scene.points[index].views) {
    const std::string element = "point " + std::to_string(point.id) + ": ";
    if (v < 0 || v >= static_cast<int>(scene.views.size())) {
      throw InputError(files.points, element + "view " + std::to_string(v) + ": does not exist");
    }
    const Eigen::Vector2d projection = scene.views[v].camera.Project(point.position);
    if (!projection.allFinite()) {
      throw InputError(files.points, element + "has no projection in " + scene.views[v].name);
    }
    AddObservation(scene.views[v], projection, &model->images[v], &point);
  }
}

void AddPoints(const Scene& scene, const ColmapFiles& files, ColmapModel* model) {
  std::vector<std::uint64_t> ids;
  ids.reserve(scene.points.size());
  for (const ScenePoint& point : scene.points) ids.push_back(point.id);
  ids = Numbers(std::move(ids), kNoId - 1);
  model->points.resize(scene.points.size());
  for (size_t p = 0; p < scene.points.size(); ++p) {
    model->points[p].id = ids[p];
    model->points[p].position = scene.points[p].position;
    AddObservations(scene, p, files, model);
  }
}

}  // namespace

void WriteColmapModel(const Scene& scene, const fs::path& workspace, bool binary) {
  const fs::path sparse = workspace / "sparse";
  const ColmapFiles files = ColmapFilesIn(sparse, binary);
  ColmapModel model;
  AddViews(scene.views, FindCameraModel("PINHOLE", 0, files.cameras), &model);
  AddPoints(scene, files, &model);
  CheckColmapModel(model, files);  // so that what is written can be read
  MakeFolder(sparse);
  if (binary) {
    WriteColmapBinary(model, files);
  } else {
    WriteColmapText(model, files);
  }
  const ColmapFiles other = ColmapFilesIn(sparse, !binary);
  for (const fs::path* file : {&other.cameras, &other.images, &other.points}) {
    std::error_code error;
    fs::remove(*file, error);
  }
}

void WriteColmapScene(const Scene& scene, const fs::path& workspace, bool binary) {
  const fs::path images = workspace / "images";
  std::set<std::string> names;
  for (const View& view : scene.views) CheckView(view, images, &names);
  WriteColmapModel(scene, workspace, binary);
  for (const View& view : scene.views) {
    MakeFolder((images / view.name).parent_path());
    WriteGrayImage(view.gray, images / view.name);
  }
}

}  // namespace burin
