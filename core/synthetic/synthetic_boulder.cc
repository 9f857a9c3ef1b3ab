// A body to walk around, without a mesh file: "scan" on a lump of its own.
#include "core/image/noise.h"
#include "core/synthetic/synthetic_layout.h"
#include "core/synthetic/synthetic_rig.h"
#include "core/synthetic/synthetic_shapes.h"

namespace burin {

SyntheticLayout BoulderLayout(const SyntheticOptions& options) {
  const double footprint = OrbitDistance(options) / (kFocalPerWidth * options.width);
  const BandNoise lumps(LayoutSeed(options, LayoutStream::kRelief), 0.35, 1.4, 1.5);
  const BandNoise bumps(LayoutSeed(options, LayoutStream::kBump), 18 * footprint, 72 * footprint,
                        1.5);
  const double bump_height = options.relief_px * footprint / 3;
  const BodyShape shape{{0.9, 0.75, 0.7}, 0, true};
  SyntheticOptions around = options;
  around.scan_up = SignedAxis::kY;
  return ScanLayout(around, BodyMesh(shape, 1.5 * footprint, [&](const Eigen::Vector3d& point) {
                      return 0.06 * lumps(point) + bump_height * bumps(point);
                    }));
}

}  // namespace burin
