// rods: what is thinner than a window, and on coarse levels thinner than a pixel.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/synthetic/synthetic_layout.h"
#include "core/synthetic/synthetic_rig.h"

namespace burin {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kDiametersPx[] = {1, 1.5, 2, 3};
constexpr int kRodsPerDiameter = 2;
constexpr double kHalfHeight = 0.72;  // in half heights of the image
constexpr double kMaxTiltDeg = 3;
constexpr double kInflatePx = 0.7;
constexpr double kBendPx = 1;
constexpr double kBendPeriods = 1.5;  // over the length of a rod
constexpr int kTruthSides = 24;
constexpr int kInitSides = 8;
// Facets of 40 px would be no rods at all.
constexpr double kInitEdgeShare = 1.0 / 8;

struct Rod {
  Eigen::Vector3d center;
  Eigen::Vector3d axis;  // unit, upwards
  double half_length;
  double radius;
};

// A closed prism around the rod's axis, with rings at most `edge` apart; a ring at t in [-1, 1] is
// shifted by shift(t). Its area is that of the rod, the ends are flat.
template <typename Shift>
void AppendRod(const Rod& rod, double radius, int sides, double edge, const Shift& shift,
               TriangleMesh* mesh) {
  const Eigen::Vector3d u = rod.axis.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d v = rod.axis.cross(u);
  const int rings = std::max(2, static_cast<int>(std::ceil(2 * rod.half_length / edge)));
  const double corner = radius * std::sqrt(2 * kPi / sides / std::sin(2 * kPi / sides));
  const int first = static_cast<int>(mesh->vertices.size());
  const auto center = [&](double t) -> Eigen::Vector3d {
    return rod.center + t * rod.half_length * rod.axis + shift(t);
  };
  for (int r = 0; r <= rings; ++r) {
    const Eigen::Vector3d middle = center(2.0 * r / rings - 1);
    for (int s = 0; s < sides; ++s) {
      const double angle = 2 * kPi * s / sides;
      mesh->vertices.emplace_back(middle + corner * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  const int bottom = static_cast<int>(mesh->vertices.size());
  mesh->vertices.push_back(center(-1));
  mesh->vertices.push_back(center(1));
  const auto at = [&](int ring, int side) { return first + ring * sides + side % sides; };
  for (int s = 0; s < sides; ++s) {
    // u, v and the axis are right-handed: counter-clockwise seen from above.
    for (int r = 0; r < rings; ++r) {
      mesh->faces.emplace_back(at(r, s), at(r, s + 1), at(r + 1, s + 1));
      mesh->faces.emplace_back(at(r, s), at(r + 1, s + 1), at(r + 1, s));
    }
    mesh->faces.emplace_back(bottom, at(0, s + 1), at(0, s));
    mesh->faces.emplace_back(bottom + 1, at(rings, s), at(rings, s + 1));
  }
}

}  // namespace

SyntheticLayout RodsLayout(const SyntheticOptions& options) {
  SyntheticLayout layout;
  const double footprint = PatchFootprint(options);
  const double half_height = kHalfHeight * options.height / options.width;
  const CounterRandom random(LayoutSeed(options, LayoutStream::kPlace), 0);
  const CounterRandom spoil(LayoutSeed(options, LayoutStream::kSpoil), 0);
  const int count = static_cast<int>(std::size(kDiametersPx)) * kRodsPerDiameter;
  for (int k = 0; k < count; ++k) {
    const auto symmetric = [&](int number) { return 2 * random.Uniform(8 * k + number) - 1; };
    const double x = 1.6 * (k + 0.5) / count - 0.8;
    const double lean = kMaxTiltDeg * kPi / 180 * symmetric(0);
    const double nod = kMaxTiltDeg * kPi / 180 * symmetric(1);
    const Rod rod = {{x + 0.02 * symmetric(2), 0.02 * symmetric(3), 0.04 * symmetric(4)},
                     Eigen::Vector3d(std::tan(lean), 1, std::tan(nod)).normalized(),
                     half_height,
                     kDiametersPx[k / kRodsPerDiameter] * footprint / 2};
    const auto straight = [](double) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); };
    AppendRod(rod, rod.radius, kTruthSides, footprint, straight, &layout.truth);

    const double direction = 2 * kPi * spoil.Uniform(2 * k);
    const double phase = 2 * kPi * spoil.Uniform(2 * k + 1);
    const Eigen::Vector3d bend =
        kBendPx * footprint * Eigen::Vector3d(std::cos(direction), 0, std::sin(direction));
    const auto bent = [&](double t) -> Eigen::Vector3d {
      return std::sin(kPi * kBendPeriods * t + phase) * bend;
    };
    AppendRod(rod, rod.radius + kInflatePx * footprint, kInitSides,
              kInitEdgeShare * options.init_edge_px * footprint, bent, &layout.init);
  }
  // A vertex further off than the rod is thick would stand on its other side.
  layout.init_noise_share = 0.25;

  CameraRig rig(options, PatchDistance(options), {0, 0, 0});
  rig.AddFan(options, 9, 36, 6, -6);
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  return layout;
}

}  // namespace burin
