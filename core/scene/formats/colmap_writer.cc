// Writing COLMAP workspaces; reading is in colmap.cc.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/image/gray_image.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/colmap_model.h"
#include "core/scene/lens_points.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

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
  const auto values = [](const View& view) {
    const Camera& camera = view.camera;
    return std::make_tuple(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
                           view.origin.camera_model, view.origin.lens.brown);
  };
  return values(a) == values(b);
}

// The model that the photograph's camera was read with, or the one that has its lens.
const ColmapCameraModel* PhotographedModel(const View& view, const ColmapFiles& files) {
  const std::string& name = view.origin.camera_model;
  const ColmapCameraModel* model = FindCameraModel(IsColmapCameraModel(name)   ? name
                                                   : view.origin.lens.IsNone() ? "PINHOLE"
                                                                               : "OPENCV",
                                                   0, files.cameras);
  for (size_t k = model->distortion_count; k < view.origin.lens.brown.size(); ++k) {
    if (view.origin.lens.brown[k] != 0) return nullptr;
  }
  const bool one_focal = model->focal_count == 1 && view.camera.fx != view.camera.fy;
  return view.origin.lens.measured != 0 || one_focal ? nullptr : model;
}

std::vector<double> ParametersOf(const View& view, const ColmapCameraModel& model) {
  const Camera& camera = view.camera;
  std::vector<double> parameters = {camera.fx};
  if (model.focal_count == 2) parameters.push_back(camera.fy);
  parameters.insert(parameters.end(), {camera.cx, camera.cy});
  const auto& brown = view.origin.lens.brown;
  parameters.insert(parameters.end(), brown.begin(), brown.begin() + model.distortion_count);
  return parameters;
}

// The number of the camera of every view: views that shared one still do, with new numbers where one is out of
// range. Every view has its own where one has no number, or a number has cameras that differ.
std::vector<std::uint64_t> CameraNumbers(const std::vector<View>& views) {
  std::vector<std::uint64_t> numbers;
  std::map<std::uint64_t, const View*> first_of;
  std::map<std::uint64_t, std::uint64_t> counted;
  bool shared = true;
  bool in_range = true;
  for (const View& view : views) {
    const std::uint64_t id = numbers.emplace_back(view.origin.camera_id);
    const View* first = first_of.emplace(id, &view).first->second;
    counted.emplace(id, counted.size() + 1);
    shared = shared && id != kNoId && HaveOneCamera(*first, view);
    in_range = in_range && id >= 1 && id <= kMostId;
  }
  if (!shared) {
    std::iota(numbers.begin(), numbers.end(), 1);
  } else if (!in_range) {
    for (std::uint64_t& number : numbers) number = counted[number];
  }
  return numbers;
}

void AddViews(const std::vector<View>& views, bool photographed, const ColmapFiles& files,
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
      camera.model = photographed ? PhotographedModel(views[v], files)
                                  : FindCameraModel("PINHOLE", 0, files.cameras);
      camera.width = from.width;
      camera.height = from.height;
      camera.parameters = photographed ? ParametersOf(views[v], *camera.model)
                                       : std::vector<double>{from.fx, from.fy, from.cx, from.cy};
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

// Where its views see a point: as measured; by projection, with an error of 0, where the scene has no measurements.
void AddObservations(const Scene& scene, size_t index, bool photographed, const ColmapFiles& files,
                     ColmapModel* model) {
  ColmapPoint& point = model->points[index];
  const auto written = [&](int v, const Eigen::Vector2d& at) {
    const View& view = scene.views[v];
    return photographed ? PhotographedAt(view.camera, view.origin.lens, at) : at;
  };
  const auto add = [&](int v, const Eigen::Vector2d& at) {
    AddObservation(scene.views[v], written(v, at), &model->images[v], &point);
  };
  if (!scene.tracks.IsEmpty()) {
    double sum = 0;
    int count = 0;
    for (const Measurement& measured : scene.tracks.Of(index)) {
      const int v = measured.view;
      add(v, measured.image_point);
      const Camera& camera = scene.views[v].camera;
      if (camera.Depth(point.position) <= 0) continue;
      const Eigen::Vector2d projection = written(v, camera.Project(point.position));
      const double error = (projection - written(v, measured.image_point)).norm();
      if (!std::isfinite(error)) continue;
      sum += error;
      ++count;
    }
    if (count > 0) point.error = sum / count;
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
    add(v, projection);
  }
}

void AddPoints(const Scene& scene, bool photographed, const ColmapFiles& files,
               ColmapModel* model) {
  std::vector<std::uint64_t> ids;
  ids.reserve(scene.points.size());
  for (const ScenePoint& point : scene.points) ids.push_back(point.id);
  ids = Numbers(std::move(ids), kNoId - 1);
  model->points.resize(scene.points.size());
  for (size_t p = 0; p < scene.points.size(); ++p) {
    model->points[p].id = ids[p];
    model->points[p].position = scene.points[p].position;
    AddObservations(scene, p, photographed, files, model);
  }
}

void WriteModel(const Scene& scene, bool photographed, const fs::path& workspace, bool binary) {
  const fs::path sparse = workspace / "sparse";
  const ColmapFiles files = ColmapFilesIn(sparse, binary);
  ColmapModel model;
  AddViews(scene.views, photographed, files, &model);
  AddPoints(scene, photographed, files, &model);
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

}  // namespace

void WriteColmapModel(const Scene& scene, const fs::path& workspace, bool binary) {
  WriteModel(scene, /*photographed=*/false, workspace, binary);
}

bool WritePhotographedModel(const Scene& scene, const fs::path& workspace) {
  const ColmapFiles files = ColmapFilesIn(workspace / "sparse", /*binary=*/false);
  const bool said = std::all_of(scene.views.begin(), scene.views.end(), [&](const View& view) {
    return PhotographedModel(view, files) != nullptr;
  });
  WriteModel(scene, said, workspace, /*binary=*/false);
  return said;
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
