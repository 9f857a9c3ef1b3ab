#include "core/scene/formats/camera_checks.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>

#include "core/support/error.h"

namespace burin {
namespace {

// Of the distance between centres, relative to the larger of their coordinates: rounding alone.
constexpr double kSameCentre = 1e-12;

// Of the picture's longer side: fields of view of 157 and of 1.1 degrees. What is beyond is in other units, or of
// a picture of another size.
constexpr double kLeastFocal = 0.1;
constexpr double kMostFocal = 50;
// Beyond these the single precision of ray casting and pixel fields overflows. Nothing real is near.
constexpr double kMostPrincipalPoint = 1e9;  // pixels
constexpr double kMostTranslation = 1e17;    // world units

constexpr int kKeptBits = 40;

// To a multiple of 2^exponent.
double RoundedTo(double value, int exponent) {
  return std::ldexp(std::round(std::ldexp(value, -exponent)), exponent);
}

std::string Text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

double OffOrthonormal(const Eigen::Matrix3d& matrix) {
  return (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

void CheckCameras(const std::vector<View>& views, const std::filesystem::path& file) {
  for (const View& view : views) {
    const Camera& camera = view.camera;
    const std::string element = view.name + ": ";
    if (camera.width <= 0 || camera.height <= 0) {
      throw InputError(file, element + "image size = " + std::to_string(camera.width) + " x " +
                                 std::to_string(camera.height) + ": must be above 0");
    }
    for (const double focal : {camera.fx, camera.fy}) {
      if (!(focal > 0) || !std::isfinite(focal)) {
        throw InputError(
            file, element + "focal length = " + Text(focal) + ": must be finite and above 0");
      }
      const int side = std::max(camera.width, camera.height);
      if (focal < kLeastFocal * side || focal > kMostFocal * side) {
        throw InputError(file, element + "focal length = " + Text(focal) + " pixels of a picture " +
                                   std::to_string(camera.width) + "x" +
                                   std::to_string(camera.height) + ": no camera's; must be in [" +
                                   Text(kLeastFocal * side) + ", " + Text(kMostFocal * side) +
                                   "] (is it in millimetres, or of a picture of another size?)");
      }
    }
    for (const double center : {camera.cx, camera.cy}) {
      if (!std::isfinite(center)) {
        throw InputError(file, element + "principal point: must be finite");
      }
      if (std::abs(center) > kMostPrincipalPoint) {
        throw InputError(file, element + "principal point = " + Text(center) +
                                   " pixels: must be within " + Text(kMostPrincipalPoint));
      }
    }
    if (!camera.rotation.allFinite() || OffOrthonormal(camera.rotation) > 1e-6 ||
        camera.rotation.determinant() < 0) {
      throw InputError(file, element + "rotation: is not a rotation matrix");
    }
    if (!camera.translation.allFinite()) {
      throw InputError(file, element + "translation: must be finite");
    }
    if (camera.translation.cwiseAbs().maxCoeff() > kMostTranslation) {
      throw InputError(file, element +
                                 "translation = " + Text(camera.translation.cwiseAbs().maxCoeff()) +
                                 ": must be within " + Text(kMostTranslation));
    }
  }
}

void CheckCentresDiffer(const std::vector<View>& views, const std::filesystem::path& file) {
  if (views.size() < 2) return;
  const Eigen::Vector3d first = views[0].camera.Center();
  for (const View& view : views) {
    const Eigen::Vector3d center = view.camera.Center();
    const double scale = std::max(first.cwiseAbs().maxCoeff(), center.cwiseAbs().maxCoeff());
    if ((center - first).cwiseAbs().maxCoeff() > kSameCentre * scale) return;
  }
  throw InputError(file, "all " + std::to_string(views.size()) +
                             " cameras have the same centre: photographs from one place show no "
                             "depth");
}

Camera Rounded(const Camera& camera) {
  Camera rounded = camera;
  for (double* value : {&rounded.fx, &rounded.fy, &rounded.cx, &rounded.cy}) {
    *value = RoundedTo(*value, -kKeptBits + 10);  // pixels, of some thousands
  }
  Eigen::Quaterniond q(camera.rotation);
  for (double& value : q.coeffs()) value = RoundedTo(value, -kKeptBits);
  rounded.rotation = q.normalized().toRotationMatrix();
  const double largest = camera.translation.cwiseAbs().maxCoeff();
  if (largest > 0) {
    for (double& value : rounded.translation) {
      value = RoundedTo(value, std::ilogb(largest) - kKeptBits);
    }
  }
  return rounded;
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix, const std::filesystem::path& file,
                                const std::string& element) {
  if (!matrix.allFinite() || OffOrthonormal(matrix) > 1e-3) {
    throw InputError(file, element + ": is not a rotation matrix, M M^T is not the identity");
  }
  if (matrix.determinant() < 0) {
    throw InputError(file, element + ": mirrors (determinant -1), must be a rotation");
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace burin
