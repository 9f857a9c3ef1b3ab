#include "core/synthetic/synthetic_stress.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace burin {
namespace {

constexpr double kMeanAlbedo = 120;
constexpr double kPatchPx = 80;
constexpr double kPeriodPx = 20;
constexpr double kOverexposure = 6;
constexpr double kPoseErrorPx = 3;
constexpr double kPi = 3.14159265358979323846;

}  // namespace

double Stress::Albedo(const std::function<double(const Eigen::Vector3d&)>& texture,
                      const Eigen::Vector3d& point) const {
  if (kind_ == StressKind::kTextureless) {
    const Eigen::Vector3d angle = point * (kPi / (kPatchPx * footprint_));
    const double cell = std::sin(angle.x()) * std::sin(angle.y());
    const double contrast = std::clamp(8 * cell, 0.0, 1.0);
    return kMeanAlbedo + contrast * (texture(point) - kMeanAlbedo);
  }
  if (kind_ == StressKind::kRepeated) {
    const double period = kPeriodPx * footprint_;
    Eigen::Vector3d folded;
    for (int c = 0; c < 3; ++c) folded[c] = point[c] - period * std::floor(point[c] / period);
    return texture(folded);
  }
  return texture(point);
}

Exposure Stress::ExposureOf(int view, const Exposure& usual) const {
  if (kind_ != StressKind::kExposure) return usual;
  // Neighbours differ: 0, 3, 1, 4, 2, 0, ... fifths.
  const double step = (3 * view % 5) / 4.0;
  return {0.6 + 0.9 * step, 20 - 40 * step};
}

void Stress::ChangeRadiance(int view, int count,
                            const std::function<double(const Eigen::Vector3d&)>& texture,
                            cv::Mat1f* radiance) const {
  if (kind_ == StressKind::kSaturated && view % 3 == 1) {
    *radiance = radiance->clone();
    radiance->colRange(0, radiance->cols / 3) *= kOverexposure;
  }
  const bool has_disc = view == count / 2 || view == count / 2 - 1;
  if (kind_ == StressKind::kMover && has_disc) {
    const double radius = radiance->rows / 8.0;
    const double x0 = radiance->cols * (view == count / 2 ? 0.4 : 0.62);
    const double y0 = radiance->rows * 0.5;
    for (int y = 0; y < radiance->rows; ++y) {
      for (int x = 0; x < radiance->cols; ++x) {
        const Eigen::Vector3d on_disc(x - x0, y - y0, 0);
        if (on_disc.norm() < radius) {
          // Far from the scene, where the texture is different.
          (*radiance)(y, x) =
              static_cast<float>(texture((on_disc + Eigen::Vector3d(1e4, 0, 0)) * footprint_));
        }
      }
    }
  }
}

Camera WithPoseNoise(const Camera& truth, double px, const CounterRandom& random, int view) {
  if (px == 0) return truth;
  const auto first = 6 * static_cast<std::uint64_t>(view);
  const double angle = px / truth.fx;
  const Eigen::Vector3d turn(angle * random.Normal(first), angle * random.Normal(first + 1),
                             2 * angle * random.Normal(first + 2));
  Eigen::Vector3d center = truth.Center();
  const double shift = 0.5 * angle * center.norm();
  for (int c = 0; c < 3; ++c) center[c] += shift * random.Normal(first + 3 + c);
  Camera camera = truth;
  const double norm = turn.norm();
  if (norm > 0) camera.rotation = Eigen::AngleAxisd(norm, turn / norm) * truth.rotation;
  camera.translation = -camera.rotation * center;
  return camera;
}

Camera WithIntrinsicsNoise(const Camera& truth, double focal, double px,
                           const CounterRandom& random, int camera) {
  const auto first = 3 * static_cast<std::uint64_t>(camera);
  Camera noisy = truth;
  // A longer one by 1 + x is as wrong as a shorter one by 1 / (1 + x): never negative.
  const double factor = std::exp(focal * random.Normal(first));
  noisy.fx *= factor;
  noisy.fy *= factor;
  noisy.cx += px * random.Normal(first + 1);
  noisy.cy += px * random.Normal(first + 2);
  return noisy;
}

Camera Stress::Calibration(int view, int count, const Camera& truth) const {
  if (kind_ != StressKind::kPose || view != count / 2) return truth;
  Camera camera = truth;
  // About the optical centre, along the diagonal of the image.
  const double angle = std::atan(kPoseErrorPx / truth.fx);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  const Eigen::Vector3d center = truth.Center();
  camera.rotation = turn * truth.rotation;
  camera.translation = -camera.rotation * center;
  return camera;
}

}  // namespace burin
