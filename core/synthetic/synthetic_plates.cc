// plates: surfaces so near to each other that a refiner can push one through another.
#include <Eigen/Geometry>
#include <algorithm>

#include "core/image/noise.h"
#include "core/synthetic/synthetic_layout.h"
#include "core/synthetic/synthetic_rig.h"
#include "core/synthetic/synthetic_shapes.h"

namespace burin {
namespace {

constexpr double kHalfWidth = 0.8;
constexpr double kFillHeight = 0.85;
constexpr double kRoundingPx = 0.5;
constexpr double kTruthEdgePx = 4;  // the plates are flat
// Of the gap: how far a point of the initial plates moves at most, before the noise of the vertices,
// and the standard deviation that this noise has at most, at the default of init_noise_px.
constexpr double kMaxBumpShare = 0.25;
constexpr double kNoiseShare = 1.0 / 8;

}  // namespace

SyntheticLayout PlatesLayout(const SyntheticOptions& options) {
  SyntheticLayout layout;
  const double footprint = PatchFootprint(options);
  const double gap = options.gap_px * footprint;
  const double half_height = kFillHeight * options.height / options.width;
  const double rounding = std::min(kRoundingPx * footprint, gap / 2);
  const BodyShape plate = {{kHalfWidth, half_height, gap / 2}, rounding, false};
  const BandNoise bumps(LayoutSeed(options, LayoutStream::kSpoil), 40 * footprint, 160 * footprint,
                        1);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d center(0, 0, side * gap);
    const auto exact = [](const Eigen::Vector3d&) { return 0.0; };
    const auto bumpy = [&](const Eigen::Vector3d& point) {
      // The four sides are far apart in the noise, so that each has bumps of its own.
      const Eigen::Vector3d spread(point.x(), point.y(), 1e3 * (point.z() + center.z()));
      const double most = kMaxBumpShare * gap;
      return std::clamp(most * bumps(spread), -most, most);
    };
    AppendMesh(BodyMesh(plate, kTruthEdgePx * footprint, exact), Eigen::Matrix3d::Identity(),
               center, &layout.truth);
    AppendMesh(BodyMesh(plate, options.init_edge_px * footprint, bumpy),
               Eigen::Matrix3d::Identity(), center, &layout.init);
  }
  layout.init_noise_share = std::min(0.5, kNoiseShare * options.gap_px);

  CameraRig rig(options, PatchDistance(options), {0, 0, 0});
  const int views = options.views > 0 ? options.views : 10;
  const int in_front = (views + 1) / 2;
  for (int k = 0; k < views; ++k) {
    const bool front = k < in_front;
    const double azimuth = front ? Spread(options, k, in_front, 28)
                                 : 180 + Spread(options, k - in_front, views - in_front, 28);
    rig.Add(azimuth, k % 2 == 0 ? 7 : -7);
  }
  layout.cameras = rig.cameras();
  layout.footprint = rig.Footprint();
  return layout;
}

}  // namespace burin
