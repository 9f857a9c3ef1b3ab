// sky: most of the background shows nothing, and the start has a surface there all the same.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/image/noise.h"
#include "core/synthetic/synthetic_layout.h"
#include "core/synthetic/synthetic_rig.h"
#include "core/synthetic/synthetic_shapes.h"

namespace burin {
namespace {

constexpr double kSkyLevel = 200;  // grey levels
constexpr double kGroundY = -0.42;
constexpr double kNear = 1.0;  // z of the ground's rims
constexpr double kFar = -2.0;
constexpr double kGroundHalfWidth = 1.6;
constexpr double kTowerHalfWidth = 0.17;
constexpr double kTowerTop = 0.5;
constexpr double kTowerSwellPx = 1.5;
constexpr double kCurtainFar = -1.3;  // z of the curtain at its ends
constexpr double kCurtainLow = 0.02;  // y of its top there

// Poisson reconstruction closes what nobody measured: a curtain from the tower's back out and away
// above the ground, its top sagging from the tower's to the horizon. It faces the cameras.
TriangleMesh Curtain(double edge) {
  const auto beside = [](double x) {  // 0 behind the tower, 1 at the ends
    return std::max(0.0, std::abs(x) - kTowerHalfWidth) / (kGroundHalfWidth - kTowerHalfWidth);
  };
  const double behind = -1.5 * kTowerHalfWidth;
  TriangleMesh curtain = HeightFieldMesh(kGroundHalfWidth, 1, edge, [&](double x, double) {
    return behind + (kCurtainFar - behind) * beside(x);
  });
  for (Eigen::Vector3d& vertex : curtain.vertices) {
    const double sag = std::pow(1 - beside(vertex.x()), 1.5);
    const double top = kCurtainLow + (kTowerTop - kCurtainLow) * sag;
    vertex.y() = kGroundY + (top - kGroundY) * (vertex.y() + 1) / 2;
  }
  return curtain;
}

}  // namespace

SyntheticLayout SkyLayout(const SyntheticOptions& options) {
  SyntheticLayout layout;
  layout.background = kSkyLevel;
  const double footprint = PatchFootprint(options);
  const double init_edge = options.init_edge_px * footprint;
  const double bump_height = options.relief_px * footprint / 3;
  const BandNoise bumps(LayoutSeed(options, LayoutStream::kBump), 18 * footprint, 72 * footprint,
                        1.5);

  // The height field's z becomes y, its y becomes -z.
  Eigen::Matrix3d lying;
  lying << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Eigen::Vector3d ground_at(0, kGroundY, (kNear + kFar) / 2);
  const double half_depth = (kNear - kFar) / 2;
  AppendMesh(HeightFieldMesh(kGroundHalfWidth, half_depth, 1.5 * footprint,
                             [&](double x, double y) {
                               return bump_height * bumps({x, y, 0});
                             }),
             lying, ground_at, &layout.truth);
  AppendMesh(
      HeightFieldMesh(kGroundHalfWidth, half_depth, init_edge, [](double, double) { return 0.0; }),
      lying, ground_at, &layout.init);

  // The tower's foot is below the ground.
  const double foot = kGroundY - 0.1;
  const Eigen::Vector3d tower_at(0, (kTowerTop + foot) / 2, 0);
  const BodyShape tower = {{kTowerHalfWidth, (kTowerTop - foot) / 2, kTowerHalfWidth}, 0.02, false};
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitY()).toRotationMatrix();
  AppendMesh(BodyMesh(tower, footprint,
                      [&](const Eigen::Vector3d& point) {
                        return 0.5 * bump_height * bumps(point + tower_at);
                      }),
             turned, tower_at, &layout.truth);
  AppendMesh(
      BodyMesh(tower, init_edge, [&](const Eigen::Vector3d&) { return kTowerSwellPx * footprint; }),
      turned, tower_at, &layout.init);
  AppendMesh(Curtain(init_edge), Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(),
             &layout.init);

  CameraRig rig(options, PatchDistance(options), {0, 0.02, 0});
  rig.AddFan(options, 8, 32, 14, 8);
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  return layout;
}

}  // namespace burin
