#include "core/synthetic/synthetic_layout.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/image/noise.h"
#include "core/support/counter_random.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic_shapes.h"

namespace burin {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kFocalPerWidth = 1.2;
// Part of the image width that 2 world units at the centre fill in relief and occluders.
constexpr double kFill = 0.92;

// Uneven rigs: every third view stands this much farther away, and azimuths around a scan are
// shifted by up to this many degrees.
constexpr double kFarFactor = 1.7;
constexpr double kCrowding = 28;

enum Stream : std::uint64_t { kCameraStream = 1, kReliefStream, kBumpStream };

std::uint64_t SubSeed(const SyntheticOptions& options, std::uint64_t stream) {
  return CounterRandom(static_cast<std::uint64_t>(options.seed), stream).Bits(0);
}

double PatchFootprint(const SyntheticOptions& options) { return 2 / (kFill * options.width); }

// Places cameras on spheres around a target; +z is the direction of azimuth and elevation 0, y is
// up. Every pose gets a small deviation, as a photographer's has.
class CameraRig {
 public:
  CameraRig(const SyntheticOptions& options, double distance, const Eigen::Vector3d& target)
      : random_(SubSeed(options, kCameraStream), 0),
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

  void Add(double azimuth_deg, double elevation_deg) {
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

  double Footprint() const { return distance_ / intrinsics_.fx; }
  const std::vector<Camera>& cameras() const { return cameras_; }

 private:
  CounterRandom random_;
  bool uneven_;
  double distance_;
  Eigen::Vector3d target_;
  Camera intrinsics_;
  std::vector<Camera> cameras_;
};

// k-th of `count` azimuths over [-half_range, half_range]; uneven ones crowd in the middle.
double Spread(const SyntheticOptions& options, int k, int count, double half_range) {
  const double t = count == 1 ? 0 : 2.0 * k / (count - 1) - 1;
  return half_range * (options.rig == RigSpacing::kUneven ? t * std::pow(std::abs(t), 0.8) : t);
}

// The rotation that turns an axis to +y.
Eigen::Matrix3d UprightRotation(SignedAxis up) {
  const int from = static_cast<int>(up) / 2;  // the values alternate in sign
  const double sign = static_cast<int>(up) % 2 == 0 ? 1 : -1;
  if (from == 1) return Eigen::Vector3d(1, sign, sign).asDiagonal();
  // The axis goes to y, y to minus the axis' place, and the third stays.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
  rotation(1, from) = sign;
  rotation(from, 1) = -sign;
  rotation(2 - from, 2 - from) = 1;
  return rotation;
}

struct Body {
  BodyShape shape;
  Eigen::Vector3d center;
  Eigen::Vector3d axis;  // of the rotation
  double angle_deg;
  double bumps;  // RMS, in thirds of relief_px
  double swell;  // of the initial body, px
};

// In front of a wall at z = 0 that is seen from about z = 2.6.
std::vector<Body> Bodies(double footprint) {
  const auto ellipsoid = [](double x, double y, double z) { return BodyShape{{x, y, z}, 0, true}; };
  const auto box = [](double x, double y, double z, double rounding) {
    return BodyShape{{x, y, z}, rounding, false};
  };
  // The thin bar stays at least three pixels wide in small images.
  const double thin = std::max(0.018, 1.5 * footprint);
  const Eigen::Vector3d diagonal = Eigen::Vector3d(1, 1, 0.5).normalized();
  return {
      {ellipsoid(0.23, 0.23, 0.23), {-0.52, 0.24, 0.45}, {0, 1, 0}, 0, 0, 2},
      {ellipsoid(0.20, 0.20, 0.20), {0.60, 0.30, 0.30}, {0, 1, 0}, 0, 1, -2},
      {ellipsoid(0.16, 0.24, 0.14), {-0.24, -0.20, 0.80}, {0, 0, 1}, 25, 1, -2},
      {ellipsoid(0.26, 0.15, 0.16), {-0.62, -0.42, 0.30}, {0, 0, 1}, -15, 1, 2},
      {box(0.17, 0.22, 0.14, 0.02), {0.44, -0.28, 0.40}, diagonal, 40, 0, -1.5},
      {box(0.50, 0.045, 0.045, 0.015), {0.10, 0.46, 0.72}, {0, 0, 1}, -8, 0, 1.5},
      {box(thin, 0.48, thin, thin), {0.17, -0.12, 0.95}, {0, 0, 1}, 12, 0, 0.5},
  };
}

}  // namespace

SyntheticLayout ReliefLayout(const SyntheticOptions& options) {
  SyntheticLayout layout;
  const double footprint = PatchFootprint(options);
  const double half_height = static_cast<double>(options.height) / options.width;
  const BandNoise relief(SubSeed(options, kReliefStream), 22 * footprint, 88 * footprint, 1.5);
  const auto base = [](double x, double y) {
    return 0.22 * std::exp(-(x * x + y * y) / 0.6) +
           0.05 * std::sin(1.7 * x + 0.6) * std::cos(2.1 * y);
  };
  layout.truth = HeightFieldMesh(1, half_height, footprint, [&](double x, double y) {
    return base(x, y) + options.relief_px * footprint * relief({x, y, 0});
  });
  layout.init = HeightFieldMesh(1, half_height, options.init_edge_px * footprint, base);

  CameraRig rig(options, footprint * kFocalPerWidth * options.width, {0, 0, 0.08});
  const int views = options.views > 0 ? options.views : 7;
  for (int k = 0; k < views; ++k) {
    rig.Add(Spread(options, k, views, 30), k % 2 == 0 ? 5 : -5);
  }
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  return layout;
}

SyntheticLayout OccludersLayout(const SyntheticOptions& options) {
  SyntheticLayout layout;
  const double footprint = PatchFootprint(options);
  const double bump_height = options.relief_px * footprint / 3;
  const BandNoise bumps(SubSeed(options, kBumpStream), 18 * footprint, 72 * footprint, 1.5);
  const double init_edge = options.init_edge_px * footprint;
  const auto swell = [](double height) {
    return [height](const Eigen::Vector3d&) { return height; };
  };

  const double half_height = 1.7 * options.height / options.width;
  const auto wall = [](double x, double y) { return 0.06 * std::sin(2.3 * x) * std::cos(1.9 * y); };
  layout.truth = HeightFieldMesh(1.7, half_height, 1.5 * footprint, [&](double x, double y) {
    return wall(x, y) + bump_height * bumps({x, y, 0});
  });
  layout.init = HeightFieldMesh(1.7, half_height, init_edge, wall);
  for (const Body& body : Bodies(footprint)) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(body.angle_deg * kPi / 180, body.axis).toRotationMatrix();
    const auto body_bumps = [&](const Eigen::Vector3d& point) {
      return body.bumps == 0 ? 0.0 : body.bumps * bump_height * bumps(point + body.center);
    };
    AppendMesh(BodyMesh(body.shape, footprint, body_bumps), rotation, body.center, &layout.truth);
    AppendMesh(BodyMesh(body.shape, init_edge, swell(body.swell * footprint)), rotation,
               body.center, &layout.init);
  }

  CameraRig rig(options, footprint * kFocalPerWidth * options.width, {0, 0, 0.2});
  const int views = options.views > 0 ? options.views : 8;
  for (int k = 0; k < views; ++k) {
    rig.Add(Spread(options, k, views, 31), k % 2 == 0 ? 11 : -9);
  }
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  return layout;
}

SyntheticLayout ScanLayout(const SyntheticOptions& options, const TriangleMesh& scan) {
  if (scan.faces.empty()) throw InputError("synth.scene = scan: needs a mesh with faces");
  const Eigen::AlignedBox3d box = BoundingBox(scan);
  const double diagonal = box.diagonal().norm();
  if (!(diagonal > 0) || !std::isfinite(diagonal)) {
    throw InputError("synth.scene = scan: the mesh has no finite extent");
  }
  SyntheticLayout layout;
  const Eigen::Vector3d center = box.center();
  double radius = 0;
  for (const Eigen::Vector3d& vertex : scan.vertices) {
    radius = std::max(radius, (vertex - center).norm());
  }
  layout.truth = scan;
  const Eigen::Matrix3d upright = UprightRotation(options.scan_up);
  for (Eigen::Vector3d& vertex : layout.truth.vertices) {
    vertex = upright * (vertex - center) / radius;
  }

  // Far enough for the unit sphere to fit the narrower field of view.
  const double half_fov =
      std::atan(0.5 * std::min(options.width, options.height) / (kFocalPerWidth * options.width));
  CameraRig rig(options, 1.03 / std::sin(half_fov), {0, 0, 0});
  const int views = options.views > 0 ? options.views : 24;
  for (int k = 0; k < views; ++k) {
    const double even = 360.0 * k / views;
    const double azimuth =
        options.rig == RigSpacing::kUneven ? even + kCrowding * std::sin(even * kPi / 180) : even;
    rig.Add(azimuth, k % 2 == 0 ? 14 : -6);
  }
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  layout.init = CoarsenedMesh(layout.truth, options.init_edge_px * layout.footprint, 2);
  return layout;
}

}  // namespace burin
