// Which taps of a correlation window show the same surface as its centre (the paper's section
// "Occlusion Aware Masking"). Where a window lies across a depth step, the taps beyond the step move
// differently under the warp and say nothing about the centre.
//
// Each window has a mask. It is made from the reference view's depths only, and frozen for a round. In
// every mode, a tap is not used when it has no surface, or when the second view does not see its surface
// point (occluded, outside the image): Omega_ij sees to that. With delta the distance from the camera to
// the surface point of a tap, and dd = delta - delta(centre):
//
//   none          every tap is valid
//   paper_strict  as printed. Taps without surface count as infinitely far. M = max dd; DD_min are
//                 the taps with dd closer to 0 than to M; sigma = dd of the tap of DD_min farthest
//                 from the centre in the image (ties: the first in row-major order; the centre if
//                 DD_min is empty). Valid: |dd - sigma| < 10 |dd - M|.
//   paper         the same with |dd| for dd, over the taps that have a surface. A window keeps all
//                 taps when the plane of the centre's facet predicts their depths (see `plane`).
//   plane         valid: the depth differs from the plane of the centre's facet by less than
//                 plane_px pixel footprints at the centre (footprint = depth / focal length).
//                 From a run's second level on it also leaves out pixels beside a step
//                 (costs/step_band.h), which knows both views.
//
// What the printed rule really does (tests/occlusion_mask_test.cc): at constant depth M = sigma = 0, and
// 0 < 0 leaves no tap. From a centre in the background it keeps a nearer occluder and drops the
// background, because M = 0.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/support/options.h"
#include "core/visibility/visibility.h"

namespace burin {

enum class MaskMode { kNone, kPaperStrict, kPaper, kPlane };
inline Choices<MaskMode> ChoicesOf(MaskMode) {
  return {{MaskMode::kNone, "none"},
          {MaskMode::kPaperStrict, "paper_strict"},
          {MaskMode::kPaper, "paper"},
          {MaskMode::kPlane, "plane"}};
}

// What becomes of a masked window with too few valid taps: left out, used in full, or used in full on
// thin things only (WindowMasks::thin).
enum class PoorWindow { kDrop, kFull, kFullThin };
inline Choices<PoorWindow> ChoicesOf(PoorWindow) {
  return {{PoorWindow::kDrop, "drop"},
          {PoorWindow::kFull, "full"},
          {PoorWindow::kFullThin, "full_thin"}};
}

struct MaskOptions {
  MaskMode mode = MaskMode::kPlane;
  double plane_px = 3;
  PoorWindow below = PoorWindow::kFullThin;
  double band_px = 3;   // costs/step_band.h; with mode plane; 0 = off
  double evidence = 4;  // pairs
  void Describe(OptionSet* set);
};

// Depths of one view and, per pixel, the plane of the facet it sees. Inverse camera depth is affine
// in the pixel on a plane: at tap (x + dx, y + dy) the plane of pixel (x, y) predicts
// inverse_depth + dx * slope_x + dy * slope_y.
struct DepthPlanes {
  int width = 0;
  int height = 0;
  double focal = 0;                  // pixels, geometric mean
  std::vector<float> inverse_depth;  // row-major; 0 = no surface
  std::vector<float> slope_x;
  std::vector<float> slope_y;
  std::vector<float> ray_length;  // distance = ray_length / inverse_depth; for the paper's rules
};

// Without `ray_lengths` that field stays empty.
DepthPlanes MakeDepthPlanes(const ViewDomain& domain, const TriangleMesh& mesh,
                            const Camera& camera, bool ray_lengths = true);

// Masks of the windows of one view that do not keep all their taps; all others are full. Those of
// row y are entries row_start[y] .. row_start[y + 1] - 1, ascending in column.
struct WindowMasks {
  int radius = 0;
  int words = 0;  // 64-bit words a mask
  std::vector<uint32_t> row_start;
  std::vector<int> column;
  std::vector<uint64_t> bits;  // `words` an entry
  // 1 for windows on something thin: they keep fewer taps than asked for, and so does every window
  // centred at one of their taps.
  std::vector<char> thin;

  // Bit of the tap (dx, dy) from the centre, each in [-radius, radius].
  bool Has(size_t entry, int dx, int dy) const {
    const int bit = (dy + radius) * (2 * radius + 1) + dx + radius;
    return (bits[entry * words + bit / 64] >> (bit % 64)) & 1U;
  }
  size_t size() const { return column.size(); }
};

// The mask of the window at (x, y) as (2 radius + 1)^2 flags, row-major. Taps outside the image or
// without surface are not valid, except with mode none, which leaves them to Omega_ij.
std::vector<char> WindowMask(const DepthPlanes& planes, int x, int y, int radius, MaskMode mode,
                             double plane_px);

// The masks of all windows whose centre has a surface. A window whose only invalid taps are those
// outside the image or without surface is full: Omega_ij leaves those out. `min_taps` decides what is
// thin.
WindowMasks MakeWindowMasks(const DepthPlanes& planes, int radius, MaskMode mode, double plane_px,
                            int min_taps);

}  // namespace burin
