#include "core/scene/formats/openmvs.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/view_names.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr uint32_t kNewestVersion = 7;
constexpr uint32_t kWrittenVersion = 6;

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

class Reader {
 public:
  explicit Reader(const fs::path& path) : path_(path), bytes_(ReadFileBytes(path)) {}

  [[noreturn]] void Fail(const std::string& field, const std::string& reason) const {
    throw InputError(path_, "byte " + std::to_string(at_) + ": " + field + ": " + reason);
  }

  template <typename T>
  T Number(const char* field) {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    if (bytes_.size() - at_ < sizeof(T)) Fail(field, "the file ends");
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  // Of things of at least `least_bytes` each: a count that the file is too short for is refused.
  uint64_t Count(const char* field, size_t least_bytes) {
    const auto count = Number<uint64_t>(field);
    if (count > (bytes_.size() - at_) / least_bytes) {
      Fail(field, std::to_string(count) + " of them do not fit the rest of the file, " +
                      std::to_string(bytes_.size() - at_) + " bytes");
    }
    return count;
  }

  std::string Text(const char* field) {
    const uint64_t size = Count(field, 1);
    std::string text = bytes_.substr(at_, size);
    at_ += size;
    for (const unsigned char c : text) {
      if (c < 0x20 || c == 0x7f) Fail(field, "contains a control character");
    }
    return text;
  }

  Eigen::Vector3d Vector(const char* field) {
    Eigen::Vector3d vector;
    for (int k = 0; k < 3; ++k) vector[k] = Number<double>(field);
    return vector;
  }

  Eigen::Matrix3d Matrix(const char* field) {
    RowMajor3 matrix;
    for (int k = 0; k < 9; ++k) matrix.data()[k] = Number<double>(field);
    return matrix;
  }

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  std::string bytes_;
  size_t at_ = 0;
};

struct MvsCamera {
  uint32_t width = 0, height = 0;
  Eigen::Matrix3d k, rotation;
  Eigen::Vector3d center;
};

struct MvsPose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d center;
};

struct MvsPlatform {
  std::vector<MvsCamera> cameras;
  std::vector<MvsPose> poses;
};

struct MvsImage {
  std::string name, mask;
  uint32_t platform = kNone, camera = kNone, pose = kNone;
  uint32_t id = kNone;
};

MvsPlatform ReadPlatform(Reader* reader, uint32_t version) {
  MvsPlatform platform;
  reader->Text("platform name");
  const uint64_t cameras = reader->Count("cameras", 8 + 21 * sizeof(double));
  for (uint64_t c = 0; c < cameras; ++c) {
    MvsCamera& camera = platform.cameras.emplace_back();
    reader->Text("camera name");
    if (version > 3) reader->Text("band name");
    if (version > 0) {
      camera.width = reader->Number<uint32_t>("camera width");
      camera.height = reader->Number<uint32_t>("camera height");
    }
    camera.k = reader->Matrix("camera K");
    camera.rotation = reader->Matrix("camera R");
    camera.center = reader->Vector("camera C");
  }
  const uint64_t poses = reader->Count("poses", 12 * sizeof(double));
  for (uint64_t p = 0; p < poses; ++p) {
    MvsPose& pose = platform.poses.emplace_back();
    pose.rotation = reader->Matrix("pose R");
    pose.center = reader->Vector("pose C");
  }
  return platform;
}

MvsImage ReadImage(Reader* reader, uint32_t version) {
  MvsImage image;
  image.name = reader->Text("image name");
  std::replace(image.name.begin(), image.name.end(), '\\', '/');
  if (version > 4) image.mask = reader->Text("mask name");
  std::replace(image.mask.begin(), image.mask.end(), '\\', '/');
  image.platform = reader->Number<uint32_t>("platform of image");
  image.camera = reader->Number<uint32_t>("camera of image");
  image.pose = reader->Number<uint32_t>("pose of image");
  if (version > 2) image.id = reader->Number<uint32_t>("image ID");
  if (version > 6) {
    for (int k = 0; k < 3; ++k) reader->Number<float>("depth of image");
    constexpr size_t kScoreBytes = 24;
    const uint64_t scores = reader->Count("view scores", kScoreBytes);
    for (uint64_t n = 0; n < scores * kScoreBytes / 4; ++n) reader->Number<uint32_t>("view score");
  }
  return image;
}

Camera CameraOf(const MvsCamera& camera, const MvsPose& pose, cv::Size size, const fs::path& path,
                const std::string& element) {
  Eigen::Matrix3d k = camera.k;
  const double larger = std::max(size.width, size.height);
  // K is for the size the camera says, or for a larger side of 1; the image may be of another size.
  // Corners stay corners, so that pixel centres at whole numbers move.
  double scale = 1;
  if (camera.width == 0 || camera.height == 0) {
    k.topRows<2>() *= larger;
    // Normalised or not, whole-numbered centres: OpenMVS scales c without the half pixel here.
  } else {
    const double width = camera.width;
    const double height = camera.height;
    if (std::abs(width * size.height - height * size.width) > std::max(width, height)) {
      throw InputError(path, element + "image size: is " + std::to_string(size.width) + " x " +
                                 std::to_string(size.height) + " but its camera is " +
                                 std::to_string(camera.width) + " x " +
                                 std::to_string(camera.height));
    }
    scale = larger / std::max(width, height);
    k.topRows<2>() *= scale;
    k(0, 2) += 0.5 * (scale - 1);
    k(1, 2) += 0.5 * (scale - 1);
  }
  Camera result = CameraOfIntrinsics(k, 0, path, element + "K");
  result.width = size.width;
  result.height = size.height;
  result.rotation = NearestRotation(camera.rotation, path, element + "camera R") *
                    NearestRotation(pose.rotation, path, element + "pose R");
  const Eigen::Vector3d center = pose.center + pose.rotation.transpose() * camera.center;
  result.translation = -result.rotation * center;
  return result;
}

// Without the folder that all photographs are in; images/ alone where that is where all are.
std::vector<std::string> NamesBelowImages(std::vector<std::string> names, const fs::path& path) {
  static constexpr std::string_view kFolder = "images/";
  const bool all_in_images = std::all_of(names.begin(), names.end(), [](const std::string& name) {
    return name.compare(0, kFolder.size(), kFolder) == 0;
  });
  if (!all_in_images) return SettledNames(names, path, /*without_common=*/true);
  for (std::string& name : names) name.erase(0, kFolder.size());
  return names;
}

class Writer {
 public:
  template <typename T>
  void Number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void Text(const std::string& text) {
    Number<uint64_t>(text.size());
    bytes_ += text;
  }
  void Vector(const Eigen::Vector3d& vector) {
    for (int k = 0; k < 3; ++k) Number(vector[k]);
  }
  void Matrix(const RowMajor3& matrix) {
    for (int k = 0; k < 9; ++k) Number(matrix.data()[k]);
  }
  std::string bytes_;
};

}  // namespace

bool IsOpenMvs(const fs::path& path) { return path.extension() == ".mvs"; }

PosedScene ReadOpenMvs(const fs::path& path, const fs::path& images) {
  Reader reader(path);
  const auto magic = reader.Number<uint32_t>("file type");
  constexpr uint32_t kInterchange = 0x4953564D;  // "MVSI"
  constexpr uint32_t kProject = 0x0053564D;      // "MVS"
  if (magic == kProject) {
    throw InputError(path,
                     "is an OpenMVS project; burin reads the interchange format (MVSI) that the "
                     "importers write");
  }
  if (magic != kInterchange)
    throw InputError(path, "does not begin with MVSI: is no OpenMVS scene");
  const auto version = reader.Number<uint32_t>("version");
  if (version > kNewestVersion) {
    throw InputError(path, "version = " + std::to_string(version) + ": at most " +
                               std::to_string(kNewestVersion) + " is known");
  }
  reader.Number<uint32_t>("reserved");
  std::vector<MvsPlatform> platforms(reader.Count("platforms", 24));
  for (MvsPlatform& platform : platforms) platform = ReadPlatform(&reader, version);
  std::vector<MvsImage> read(reader.Count("images", 20));
  for (MvsImage& image : read) image = ReadImage(&reader, version);

  PosedScene posed;
  posed.file = path;
  std::vector<int> index(read.size(), -1);
  int without = 0;
  std::string first_without;
  std::vector<const MvsImage*> used;
  std::vector<fs::path> paths;
  std::vector<std::string> names;
  for (size_t i = 0; i < read.size(); ++i) {
    const MvsImage& image = read[i];
    if (image.pose == kNone) {
      if (++without == 1) first_without = image.name;
      continue;
    }
    const std::string element = "image " + image.name + ": ";
    if (image.platform >= platforms.size() ||
        image.camera >= platforms[image.platform].cameras.size() ||
        image.pose >= platforms[image.platform].poses.size()) {
      throw InputError(path, element + "its platform, camera or pose does not exist");
    }
    index[i] = static_cast<int>(used.size());
    used.push_back(&image);
    const fs::path name = fs::path(image.name);
    names.push_back(image.name);
    const fs::path beside = path.parent_path();
    if (images.empty()) {
      std::error_code error;
      // Where the file says; else beside the file, as a copied scene has it.
      paths.push_back(fs::exists(beside / name, error)
                          ? beside / name
                          : FindPhotograph(name.filename().string(), {beside, beside / "images"}));
    } else {
      paths.push_back(FindPhotographBelow(image.name, images));
    }
  }
  if (used.empty() && without > 0) {
    throw InputError(path, std::to_string(without) + " views, none has a pose");
  }
  if (without > 0) {
    posed.notes.push_back(std::to_string(without) + " of " + std::to_string(read.size()) +
                          " views left out: they have no pose; the first is " + first_without);
  }
  names = NamesBelowImages(names, path);
  const std::vector<cv::Size> sizes = PhotographSizes(paths);
  for (size_t i = 0; i < used.size(); ++i) {
    const MvsImage& image = *used[i];
    const MvsPlatform& platform = platforms[image.platform];
    PosedImage& view = posed.images.emplace_back();
    view.name = names[i];
    view.image_path = paths[i];
    if (image.id != kNone) view.image_id = image.id;
    view.camera_id = uint64_t{image.platform} << 32U | image.camera;
    if (!image.mask.empty()) view.mask_path = path.parent_path() / image.mask;
    view.camera = CameraOf(platform.cameras[image.camera], platform.poses[image.pose], sizes[i],
                           path, "image " + image.name + ": ");
  }
  const uint64_t points = reader.Count("points", 3 * sizeof(float) + 8);
  for (uint64_t p = 0; p < points; ++p) {
    ScenePoint& point = posed.points.emplace_back();
    for (int k = 0; k < 3; ++k) point.position[k] = reader.Number<float>("point");
    if (!point.position.allFinite()) reader.Fail("point", "is not finite");
    const uint64_t views = reader.Count("views of point", 8);
    for (uint64_t v = 0; v < views; ++v) {
      const auto image = reader.Number<uint32_t>("view of point");
      reader.Number<float>("confidence");
      if (image >= index.size()) {
        reader.Fail("view of point", "image " + std::to_string(image) + " does not exist");
      }
      if (index[image] >= 0) point.views.push_back(index[image]);
    }
  }
  return posed;
}

void WriteOpenMvs(const Scene& scene, const fs::path& path) {
  Writer writer;
  writer.bytes_ = "MVSI";
  writer.Number(kWrittenVersion);
  writer.Number<uint32_t>(0);
  const RowMajor3 identity = RowMajor3::Identity();
  writer.Number<uint64_t>(1);  // platform
  writer.Text("burin");
  writer.Number<uint64_t>(scene.views.size());
  for (const View& view : scene.views) {
    const Camera& camera = view.camera;
    writer.Text("PINHOLE");
    writer.Text("");  // band
    writer.Number<uint32_t>(camera.width);
    writer.Number<uint32_t>(camera.height);
    RowMajor3 k;
    k << camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1;
    writer.Matrix(k);
    writer.Matrix(identity);
    writer.Vector(Eigen::Vector3d::Zero());
  }
  writer.Number<uint64_t>(scene.views.size());
  for (const View& view : scene.views) {
    writer.Matrix(view.camera.rotation);
    writer.Vector(view.camera.Center());
  }
  const bool has_ids = std::all_of(scene.views.begin(), scene.views.end(),
                                   [](const View& view) { return view.origin.image_id < kNone; });
  writer.Number<uint64_t>(scene.views.size());
  for (uint32_t v = 0; v < scene.views.size(); ++v) {
    writer.Text("images/" + scene.views[v].name);
    writer.Text(scene.views[v].mask.empty() ? "" : "masks/" + scene.views[v].name + ".png");
    writer.Number<uint32_t>(0);  // platform
    writer.Number(v);            // camera
    writer.Number(v);            // pose
    writer.Number(has_ids ? static_cast<uint32_t>(scene.views[v].origin.image_id) : v);
  }
  writer.Number<uint64_t>(scene.points.size());
  for (const ScenePoint& point : scene.points) {
    for (int k = 0; k < 3; ++k) writer.Number(static_cast<float>(point.position[k]));
    writer.Number<uint64_t>(point.views.size());
    for (const int view : point.views) {
      writer.Number(static_cast<uint32_t>(view));
      writer.Number(0.0F);
    }
  }
  // No normals, colours, lines, their normals and colours.
  for (int k = 0; k < 5; ++k) writer.Number<uint64_t>(0);
  const Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
  for (int k = 0; k < 16; ++k) writer.Number(transform.data()[k]);
  writer.Matrix(identity);  // bounding box, none
  writer.Vector(Eigen::Vector3d::Zero());
  writer.Vector(Eigen::Vector3d::Zero());
  WriteTextAtomically(path, writer.bytes_);
}

}  // namespace burin
