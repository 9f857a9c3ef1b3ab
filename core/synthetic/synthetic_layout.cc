#include "core/synthetic/synthetic_layout.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/image/noise.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic_rig.h"
#include "core/synthetic/synthetic_shapes.h"

namespace burin {
namespace {

constexpr double kPi = 3.141592653589793;
// Azimuths of uneven rigs around a scan are shifted by up to this many degrees.
constexpr double kCrowding = 28;

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
  const BandNoise relief(LayoutSeed(options, LayoutStream::kRelief), 22 * footprint, 88 * footprint,
                         1.5);
  const auto base = [](double x, double y) {
    return 0.22 * std::exp(-(x * x + y * y) / 0.6) +
           0.05 * std::sin(1.7 * x + 0.6) * std::cos(2.1 * y);
  };
  layout.truth = HeightFieldMesh(1, half_height, footprint, [&](double x, double y) {
    return base(x, y) + options.relief_px * footprint * relief({x, y, 0});
  });
  layout.init = HeightFieldMesh(1, half_height, options.init_edge_px * footprint, base);

  CameraRig rig(options, PatchDistance(options), {0, 0, 0.08});
  rig.AddFan(options, 7, 30, 5, -5);
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  return layout;
}

SyntheticLayout OccludersLayout(const SyntheticOptions& options) {
  SyntheticLayout layout;
  const double footprint = PatchFootprint(options);
  const double bump_height = options.relief_px * footprint / 3;
  const BandNoise bumps(LayoutSeed(options, LayoutStream::kBump), 18 * footprint, 72 * footprint,
                        1.5);
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

  CameraRig rig(options, PatchDistance(options), {0, 0, 0.2});
  rig.AddFan(options, 8, 31, 11, -9);
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

  CameraRig rig(options, OrbitDistance(options), {0, 0, 0});
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
