#include "core/scene/formats/posed_images.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "core/image/gray_image.h"
#include "core/image/image_size.h"
#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/photograph_checks.h"
#include "core/scene/lens_points.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"
#include "core/support/parallel.h"
#include "core/support/spelling.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastPhotographed = 0.5;
constexpr double kMostCoordinate = 1e30;  // of points, as of meshes

void RequireFolder(const fs::path& folder) {
  std::error_code error;
  if (fs::is_directory(folder, error)) return;
  throw InputError(folder, fs::exists(folder, error) ? "is not a folder" : "folder is missing");
}

// Of several failing items the first is reported, whatever the threads.
void ForEachInParallel(size_t count, const std::function<void(size_t)>& call) {
  std::vector<std::exception_ptr> errors(count);
  ParallelFor(static_cast<int>(count), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      try {
        call(i);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

void CheckSize(const fs::path& path, const cv::Mat& image, const PosedImage& posed) {
  const Camera& camera = posed.camera;
  if (image.cols == camera.width && image.rows == camera.height) return;
  throw InputError(path, "image size: is " + SizeText(image.cols, image.rows) + " but " +
                             posed.camera_name + " is " + SizeText(camera.width, camera.height) +
                             (image.cols == camera.height && image.rows == camera.width
                                  ? " (turned by its EXIF orientation? burin reads pixels as they "
                                    "are stored, as COLMAP does)"
                                  : ""));
}

cv::Mat ReadSized(const fs::path& path, const PosedImage& posed) {
  cv::Mat gray = ReadGrayImage(path);
  CheckSize(path, gray, posed);
  return gray;
}

cv::Mat ReadViewImage(const PosedImage& posed) {
  const cv::Mat gray = ReadSized(posed.image_path, posed);
  return posed.lens.IsNone() ? gray : Undistort(gray, posed.camera, posed.lens);
}

// Zero wherever the lens mixes in a pixel that is not to be used, or comes from outside the photograph.
// Empty when all pixels are to be used.
cv::Mat ReadViewMask(const fs::path& path, const PosedImage& posed, const fs::path& file) {
  cv::Mat used;
  if (!path.empty()) used = ReadSized(path, posed) != 0;
  if (posed.lens.IsNone()) return used;
  if (!used.empty()) used = Undistort(used, posed.camera, posed.lens) == 255;
  const cv::Mat photographed = PhotographedPixels(posed.camera, posed.lens);
  const double share = static_cast<double>(cv::countNonZero(photographed)) /
                       (static_cast<double>(photographed.rows) * photographed.cols);
  if (share < kLeastPhotographed) {
    throw InputError(file, "image " + posed.name + ": its lens leaves " +
                               std::to_string(std::lround(100 * share)) +
                               " % of the picture: the distortion coefficients cannot be right");
  }
  if (share == 1) return used;
  if (used.empty()) return photographed;
  return used & photographed;
}

// The share of each pixel that the object covers, from a mask whose largest grey level stands for all of it (some have 1
// there). Outside the photograph there is no object.
void ReadViewObject(const fs::path& path, const PosedImage& posed, View* view) {
  if (path.empty()) return;
  view->photographed = cv::Mat();
  const cv::Mat mask = ReadSized(path, posed);
  double largest = 0;
  cv::minMaxLoc(mask, nullptr, &largest);
  mask.convertTo(view->object, CV_8U, largest > 0 ? 255 / largest : 0);
  if (posed.lens.IsNone()) return;
  view->object = Undistort(view->object, posed.camera, posed.lens);
  view->photographed = PhotographedPixels(posed.camera, posed.lens);
  view->object.setTo(0, view->photographed == 0);
}

fs::path MaskOf(const PosedImage& posed, const fs::path& masks) {
  std::error_code error;
  if (!masks.empty()) {
    fs::path mask = masks / (posed.name + ".png");
    if (fs::exists(mask, error)) return mask;
  }
  return posed.mask_path;
}

void WriteUndistorted(const PosedImage& posed, const fs::path& target) {
  const std::string extension = WritableExtension(target);
  cv::Mat image = cv::imread(posed.image_path.string(), cv::IMREAD_ANYDEPTH | cv::IMREAD_COLOR |
                                                            cv::IMREAD_IGNORE_ORIENTATION);
  if (image.empty()) throw InputError(posed.image_path, "is not an image that can be read");
  CheckSize(posed.image_path, image, posed);
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1 / 257.0);
  std::vector<cv::Mat> channels;
  cv::split(image, channels);
  for (cv::Mat& channel : channels) channel = Undistort(channel, posed.camera, posed.lens);
  cv::merge(channels, image);
  std::vector<unsigned char> bytes;
  if (!cv::imencode(extension, image, bytes, {cv::IMWRITE_JPEG_QUALITY, 95})) {
    throw InputError(target, "cannot be encoded");
  }
  WriteTextAtomically(target, std::string(bytes.begin(), bytes.end()));
}

// The points that two views see, and their tracks, undistorted.
void AddPoints(const PosedScene& posed, const std::vector<int>& view_of_image, Scene* scene) {
  std::vector<PointUndistortion> undistortion;
  for (const View& view : scene->views) undistortion.emplace_back(view.camera, view.origin.lens);
  int bad = 0;
  for (size_t p = 0; p < posed.points.size(); ++p) {
    const ScenePoint& point = posed.points[p];
    if (!point.position.allFinite() || point.position.cwiseAbs().maxCoeff() >= kMostCoordinate) {
      ++bad;
      continue;
    }
    std::set<int> views;
    for (const int image : point.views) views.insert(view_of_image[image]);
    if (views.size() < 2) continue;
    scene->points.push_back(
        {point.position, std::vector<int>(views.begin(), views.end()), point.id});
    if (posed.tracks.IsEmpty()) continue;
    scene->tracks.BeginPoint();
    for (Measurement measurement : posed.tracks.Of(p)) {
      measurement.view = view_of_image[measurement.view];
      const auto image_point = undistortion[measurement.view](measurement.image_point);
      if (!image_point.has_value()) continue;
      measurement.image_point = *image_point;
      scene->tracks.Add(measurement);
    }
  }
  if (bad > 0) {
    scene->notes.push_back(std::to_string(bad) +
                           " sparse points left out: a coordinate is not a number below 1e30");
  }
}

}  // namespace

Scene MakeScene(const PosedScene& posed, bool with_images, const fs::path& masks,
                MaskMeaning meaning) {
  if (!masks.empty()) RequireFolder(masks);
  if (with_images && !posed.images_folder.empty()) RequireFolder(posed.images_folder);
  std::vector<size_t> order(posed.images.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return posed.images[a].name < posed.images[b].name; });
  Scene scene;
  scene.notes = posed.notes;
  std::vector<int> view_of_image(order.size());
  for (const size_t k : order) {
    const PosedImage& image = posed.images[k];
    if (!scene.views.empty() && scene.views.back().name == image.name) {
      throw InputError(posed.file, "image " + image.name + ": appears twice");
    }
    view_of_image[k] = static_cast<int>(scene.views.size());
    View& view = scene.views.emplace_back();
    view.name = image.name;
    view.image_path = image.image_path;
    view.camera = image.camera;
    view.origin = {image.image_id, image.camera_id, image.camera_model, image.lens};
  }
  if (scene.views.size() < 2) {
    throw InputError(posed.file, "has " + std::to_string(scene.views.size()) +
                                     " image(s): at least 2 are needed");
  }
  CheckCameras(scene.views, posed.file);
  for (View& view : scene.views) view.camera = Rounded(view.camera);
  CheckCentresDiffer(scene.views, posed.file);
  if (with_images) {
    RequirePhotographs(posed);
    ForEachInParallel(order.size(), [&](size_t i) {
      View& view = scene.views[i];
      const PosedImage& image = posed.images[order[i]];
      view.gray = ReadViewImage(image);
      view.mask_path = MaskOf(image, masks);
      view.mask = ReadViewMask(view.mask_path, image, posed.file);
      if (meaning == MaskMeaning::kObject) ReadViewObject(view.mask_path, image, &view);
    });
    const bool any_mask =
        std::any_of(posed.images.begin(), posed.images.end(),
                    [&](const PosedImage& i) { return !MaskOf(i, masks).empty(); });
    if (!masks.empty() && !any_mask) {
      throw InputError(masks, "no image has a mask; that of " + scene.views[0].name +
                                  " would be called " + scene.views[0].name + ".png");
    }
    if (meaning == MaskMeaning::kObject && !any_mask) {
      throw InputError("masks.meaning = object: no image of " + posed.file.string() +
                       " has a mask; --masks DIR says where they are");
    }
  }
  AddPoints(posed, view_of_image, &scene);
  return scene;
}

void ReadPixels(const std::vector<View*>& views) {
  ForEachInParallel(views.size(), [&](size_t i) {
    View& view = *views[i];
    PosedImage image;
    image.name = view.name;
    image.image_path = view.image_path;
    image.camera = view.camera;
    image.lens = view.origin.lens;
    view.gray = ReadViewImage(image);
    view.mask = ReadViewMask(view.mask_path, image, view.image_path);
    if (!view.object.empty()) ReadViewObject(view.mask_path, image, &view);
  });
}

void CheckPhotographTargets(const PosedScene& posed, const fs::path& folder, bool overwrite) {
  ForEachInParallel(posed.images.size(), [&](size_t i) {
    const PosedImage& image = posed.images[i];
    const fs::path target = folder / image.name;
    if (!image.lens.IsNone()) WritableExtension(target);
    std::error_code error;
    if (!fs::exists(target, error)) return;
    if (image.lens.IsNone()) {
      if (overwrite || IsSameFile(target, image.image_path)) return;
      if (fs::is_regular_file(target, error) &&
          ReadFileBytes(target) == ReadFileBytes(image.image_path)) {
        return;
      }
    } else if (IsSameFile(target, image.image_path)) {
      throw InputError(target, "would be replaced by its undistorted version: name another output");
    } else if (overwrite) {
      return;
    }
    ThrowExists(target);
  });
}

void ThrowExists(const fs::path& file) {
  throw InputError(file, "exists already: --overwrite replaces it, or name another output");
}

bool IsSameFile(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::exists(a, error) && fs::equivalent(a, b, error);
}

void WritePhotographs(const PosedScene& posed, const fs::path& folder) {
  for (const PosedImage& image : posed.images) {
    MakeFolder((folder / image.name).parent_path());
  }
  ForEachInParallel(posed.images.size(), [&](size_t i) {
    const PosedImage& image = posed.images[i];
    const fs::path target = folder / image.name;
    if (image.lens.IsNone()) {
      if (!IsSameFile(target, image.image_path)) {
        WriteTextAtomically(target, ReadFileBytes(image.image_path));
      }
    } else {
      WriteUndistorted(image, target);
    }
  });
}

std::vector<cv::Size> PhotographSizes(const std::vector<fs::path>& paths) {
  std::vector<cv::Size> sizes(paths.size());
  ForEachInParallel(paths.size(), [&](size_t i) { sizes[i] = ImageSize(paths[i]); });
  return sizes;
}

fs::path FindPhotograph(const std::string& name, const std::vector<fs::path>& folders) {
  std::string looked_in;
  for (const fs::path& named : folders) {
    const fs::path folder = named.empty() ? "." : named;
    std::error_code error;
    const fs::path path = AsSpelled(folder / name);
    if (fs::is_regular_file(path, error)) return path;
    looked_in += (looked_in.empty() ? "" : ", ") + folder.string();
  }
  throw InputError("photograph " + name + ": is in none of " + looked_in +
                   "; --images DIR says where they are");
}

Camera CameraOfIntrinsics(const Eigen::Matrix3d& intrinsics, double pixel_centre,
                          const fs::path& file, const std::string& element) {
  const Eigen::Matrix3d k = intrinsics / intrinsics(2, 2);
  if (!k.allFinite() || std::abs(k(1, 0)) + std::abs(k(2, 0)) + std::abs(k(2, 1)) > 1e-9) {
    throw InputError(file, element + ": is not an upper triangular calibration matrix");
  }
  if (std::abs(k(0, 1)) > 1e-6 * std::abs(k(0, 0))) {
    throw InputError(file, element + ": skew = " + std::to_string(k(0, 1)) + ": must be 0");
  }
  Camera camera;
  camera.fx = k(0, 0);
  camera.fy = k(1, 1);
  camera.cx = k(0, 2) + 0.5 - pixel_centre;
  camera.cy = k(1, 2) + 0.5 - pixel_centre;
  return camera;
}

Camera CameraOfProjection(const Eigen::Matrix<double, 3, 4>& projection, cv::Size size,
                          const fs::path& file, const std::string& element) {
  const Eigen::Matrix3d left = projection.leftCols<3>();
  const double scale = left.row(2).norm();
  if (!projection.allFinite() || std::abs(left.determinant()) <= 1e-12 * std::pow(scale, 3)) {
    throw InputError(file, element + ": projection matrix is singular");
  }
  // M = K R up to scale and sign; the QR factors of the rows in reverse order give K upper triangular.
  const double sign = left.determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d m = sign * left / scale;
  const Eigen::Matrix3d reversed = m.colwise().reverse().transpose();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(reversed);
  const Eigen::Matrix3d q = qr.householderQ();
  const Eigen::Matrix3d r = q.transpose() * reversed;
  Eigen::Matrix3d k = r.transpose().colwise().reverse().rowwise().reverse();
  Eigen::Matrix3d rotation = q.transpose().colwise().reverse();
  for (int c = 0; c < 3; ++c) {
    if (k(c, c) >= 0) continue;
    k.col(c) = -k.col(c);
    rotation.row(c) = -rotation.row(c);
  }
  k(1, 0) = k(2, 0) = k(2, 1) = 0;
  // Six digits, which files of projection matrices often have, leave a skew of 1e-6 focal lengths; 2e-5
  // is 0.03 px at 3000 pixels' focal length.
  if (std::abs(k(0, 1)) < 2e-5 * k(0, 0)) k(0, 1) = 0;
  Camera camera = CameraOfIntrinsics(k, 0, file, element);
  camera.width = size.width;
  camera.height = size.height;
  camera.rotation = rotation;
  camera.translation = k.inverse() * (sign * projection.col(3) / scale);
  return camera;
}

}  // namespace burin
