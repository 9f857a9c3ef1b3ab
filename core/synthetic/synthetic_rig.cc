#include "core/synthetic/synthetic_rig.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kFill = 0.92;
constexpr double kFarFactor = 1.7;

}  // namespace

std::uint64_t LayoutSeed(const SyntheticOptions& options, LayoutStream stream) {
  return CounterRandom(static_cast<std::uint64_t>(options.seed), static_cast<std::uint64_t>(stream))
      .Bits(0);
}

double PatchFootprint(const SyntheticOptions& options) { return 2 / (kFill * options.width); }

double PatchDistance(const SyntheticOptions& options) {
  return PatchFootprint(options) * kFocalPerWidth * options.width;
}

double OrbitDistance(const SyntheticOptions& options) {
  const double half_fov =
      std::atan(0.5 * std::min(options.width, options.height) / (kFocalPerWidth * options.width));
  return 1.03 / std::sin(half_fov);
}

CameraRig::CameraRig(const SyntheticOptions& options, double distance,
                     const Eigen::Vector3d& target)
    : random_(LayoutSeed(options, LayoutStream::kCamera), 0),
      uneven_(options.rig == RigSpacing::kUneven),
      distance_(distance),
      target_(target) {
  intrinsics_.width = options.width;
  intrinsics_.height = options.height;
  intrinsics_.fx = intrinsics_.fy = kFocalPerWidth * options.width;
  // Off the middle, as in real cameras, so that a mirrored or shifted principal point shows.
  intrinsics_.cx = 0.507 * options.width;
  intrinsics_.cy = 0.494 * options.height;
}

void CameraRig::Add(double azimuth_deg, double elevation_deg) {
  const std::size_t k = cameras_.size();
  const double distance = uneven_ && k % 3 == 1 ? kFarFactor * distance_ : distance_;
  const std::uint64_t first = 4 * cameras_.size();
  const double azimuth = (azimuth_deg + 0.7 * random_.Normal(first)) * kPi / 180;
  const double elevation = (elevation_deg + 0.7 * random_.Normal(first + 1)) * kPi / 180;
  const double roll = 2.0 * random_.Normal(first + 2) * kPi / 180;
  const Eigen::Vector3d backward(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                                 std::cos(azimuth) * std::cos(elevation));
  Camera camera = intrinsics_;
  const Eigen::Vector3d forward = -backward;
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitY()).normalized();
  camera.rotation.row(0) = right;
  camera.rotation.row(1) = forward.cross(right);
  camera.rotation.row(2) = forward;
  camera.rotation =
      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix() * camera.rotation;
  camera.translation = -camera.rotation * (target_ + distance * backward);
  cameras_.push_back(camera);
}

void CameraRig::AddFan(const SyntheticOptions& options, int usual, double half_range,
                       double even_deg, double odd_deg) {
  const int views = options.views > 0 ? options.views : usual;
  for (int k = 0; k < views; ++k) {
    Add(Spread(options, k, views, half_range), k % 2 == 0 ? even_deg : odd_deg);
  }
}

double Spread(const SyntheticOptions& options, int k, int count, double half_range) {
  const double t = count == 1 ? 0 : 2.0 * k / (count - 1) - 1;
  return half_range * (options.rig == RigSpacing::kUneven ? t * std::pow(std::abs(t), 0.8) : t);
}

}  // namespace burin
