#include "costs/occlusion_mask.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;
constexpr int kRowGrain = 8;
constexpr double kPaperRatio = 10;  // of the printed rule

// A tap of a window as the rules of the paper see it.
struct Tap {
  double dd = 0;
  double image_distance = 0;  // squared, from the centre
};

// sigma and M of the printed rule over the taps with a finite dd; M as given.
double PrintedSigma(const std::vector<Tap>& taps, double max) {
  double sigma = 0;
  double farthest = -1;
  for (const Tap& tap : taps) {
    if (!std::isfinite(tap.dd) || std::abs(tap.dd) >= std::abs(tap.dd - max)) continue;
    if (tap.image_distance > farthest) {
      farthest = tap.image_distance;
      sigma = tap.dd;
    }
  }
  return sigma;
}

bool PrintedRule(double dd, double sigma, double max) {
  return std::isfinite(dd) && std::abs(dd - sigma) < kPaperRatio * std::abs(dd - max);
}

// Whether the depth of the tap differs from what the centre's plane predicts by less than `limit` =
// plane_px / focal, in units of the centre's depth: |1/s - 1/predicted| < limit / centre.
bool OnPlane(float s, float predicted, float centre, float limit) {
  return predicted > 0 && std::abs(predicted - s) * centre < limit * s * predicted;
}

// Windows that may not keep all taps: some tap with a surface is off the centre's plane.
void FlagRow(const DepthPlanes& planes, int y, int radius, float limit, std::vector<char>* flags) {
  const int width = planes.width;
  std::fill(flags->begin(), flags->end(), static_cast<char>(0));
  char* __restrict flag = flags->data();
  const size_t row = static_cast<size_t>(y) * width;
  const float* __restrict centre = planes.inverse_depth.data() + row;
  const float* __restrict slope_x = planes.slope_x.data() + row;
  const float* __restrict slope_y = planes.slope_y.data() + row;
  for (int dy = -radius; dy <= radius; ++dy) {
    if (y + dy < 0 || y + dy >= planes.height) continue;
    const float* tap_row = planes.inverse_depth.data() + static_cast<size_t>(y + dy) * width;
    for (int dx = -radius; dx <= radius; ++dx) {
      const int begin = std::max(0, -dx);
      const int end = std::min(width, width - dx);
      const float* __restrict tap = tap_row + dx;
      for (int x = begin; x < end; ++x) {
        const float predicted =
            centre[x] + static_cast<float>(dx) * slope_x[x] + static_cast<float>(dy) * slope_y[x];
        const float difference = std::abs(predicted - tap[x]) * centre[x];
        const bool off = !(difference < limit * tap[x] * predicted) || !(predicted > 0);
        flag[x] |= static_cast<char>(off && tap[x] != 0 && centre[x] != 0);
      }
    }
  }
}

// WindowMask() of MaskMode::kPlane as bits, which begin as zeros. False where every tap with a surface is kept.
bool PlaneBits(const DepthPlanes& planes, int x, int y, int radius, float limit, uint64_t* bits) {
  const size_t at = static_cast<size_t>(y) * planes.width + x;
  const float centre = planes.inverse_depth[at];
  const float slope_x = planes.slope_x[at];
  const float slope_y = planes.slope_y[at];
  bool some_off = false;
  int bit = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx, ++bit) {
      if (x + dx < 0 || x + dx >= planes.width || y + dy < 0 || y + dy >= planes.height) continue;
      const float tap = planes.inverse_depth[static_cast<size_t>(y + dy) * planes.width + x + dx];
      if (tap == 0) continue;
      const float predicted =
          centre + static_cast<float>(dx) * slope_x + static_cast<float>(dy) * slope_y;
      const bool on_plane = OnPlane(tap, predicted, centre, limit);
      bits[bit / 64] |= uint64_t{on_plane} << (bit % 64);
      some_off = some_off || !on_plane;
    }
  }
  return some_off;
}

// Fills masks->thin.
void FlagThin(const DepthPlanes& planes, int min_taps, WindowMasks* masks) {
  const int radius = masks->radius;
  // Pixels whose window keeps too few taps; those without surface have no window.
  std::vector<char> poor(planes.inverse_depth.size(), 0);
  for (size_t p = 0; p < poor.size(); ++p) poor[p] = planes.inverse_depth[p] == 0 ? 1 : 0;
  std::vector<size_t> poor_entries;
  std::vector<int> poor_rows;
  for (int y = 0; y < planes.height; ++y) {
    for (size_t entry = masks->row_start[y]; entry < masks->row_start[y + 1]; ++entry) {
      int kept = 0;
      for (int word = 0; word < masks->words; ++word) {
        kept += __builtin_popcountll(masks->bits[entry * masks->words + word]);
      }
      if (kept >= min_taps) continue;
      poor[static_cast<size_t>(y) * planes.width + masks->column[entry]] = 1;
      poor_entries.push_back(entry);
      poor_rows.push_back(y);
    }
  }
  masks->thin.assign(masks->size(), 0);
  for (size_t k = 0; k < poor_entries.size(); ++k) {
    const size_t entry = poor_entries[k];
    bool thin = true;
    for (int dy = -radius; dy <= radius && thin; ++dy) {
      for (int dx = -radius; dx <= radius && thin; ++dx) {
        if (!masks->Has(entry, dx, dy)) continue;  // kept taps are inside the image
        thin = poor[static_cast<size_t>(poor_rows[k] + dy) * planes.width + masks->column[entry] +
                    dx] != 0;
      }
    }
    masks->thin[entry] = thin ? 1 : 0;
  }
}

}  // namespace

void MaskOptions::Describe(OptionSet* set) {
  set->Add("mask.mode", &mode,
           "Taps of a window beyond a depth step: none = all used; paper_strict, paper = the "
           "paper's rule as printed, corrected; plane = off the centre facet's plane are not used");
  set->Add("mask.plane_px", &plane_px,
           "Depth off the centre facet's plane from which a tap is beyond a step, pixel footprints",
           0.01, 1e6);
  set->Add(
      "mask.below", &below,
      "Masked windows with a smaller share of valid taps than photo.min_valid_share: drop them; "
      "use them in full, as without masks; or full_thin = drop them except on thin things, "
      "where no neighbour has more");
  set->Add(
      "mask.band_px", &band_px,
      "With plane, from the second level on: pixels this near to a depth step of either view are "
      "left out where enough pairs see the surface clear of steps; 0 = off",
      0, 100);
  set->Add("mask.evidence", &evidence,
           "Pairs that must see a facet's patch clear of steps for mask.band_px, on average", 0,
           1e6);
}

DepthPlanes MakeDepthPlanes(const ViewDomain& domain, const TriangleMesh& mesh,
                            const Camera& camera, bool ray_lengths) {
  DepthPlanes planes;
  planes.width = domain.width;
  planes.height = domain.height;
  planes.focal = std::sqrt(camera.fx * camera.fy);
  const ViewRays rays(camera);
  const size_t pixels = static_cast<size_t>(domain.width) * domain.height;
  planes.inverse_depth.assign(pixels, 0);
  planes.slope_x.assign(pixels, 0);
  planes.slope_y.assign(pixels, 0);
  if (ray_lengths) planes.ray_length.assign(pixels, 0);
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const InverseDepthPlane plane =
          MakeInverseDepth(mesh.vertices, mesh.faces[domain.facet[k]], rays);
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        const uint32_t p = pixel.index;
        planes.inverse_depth[p] = static_cast<float>(plane.At(pixel.x(), pixel.y()));
        planes.slope_x[p] = static_cast<float>(plane.slope_x);
        planes.slope_y[p] = static_cast<float>(plane.slope_y);
        if (!ray_lengths) continue;
        planes.ray_length[p] = static_cast<float>(camera.Ray(pixel.x(), pixel.y()).norm());
      }
    }
  });
  return planes;
}

std::vector<char> WindowMask(const DepthPlanes& planes, int x, int y, int radius, MaskMode mode,
                             double plane_px) {
  const int side = 2 * radius + 1;
  std::vector<char> mask(static_cast<size_t>(side) * side, 1);
  if (mode == MaskMode::kNone) return mask;
  const size_t centre = static_cast<size_t>(y) * planes.width + x;
  const auto limit = static_cast<float>(plane_px / planes.focal);
  const double infinity = std::numeric_limits<double>::infinity();
  const double distance = planes.ray_length[centre] / planes.inverse_depth[centre];
  std::vector<Tap> taps(mask.size());
  bool all_on_plane = true;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const size_t k = static_cast<size_t>(dy + radius) * side + dx + radius;
      taps[k].image_distance = dx * dx + dy * dy;
      const bool inside =
          x + dx >= 0 && x + dx < planes.width && y + dy >= 0 && y + dy < planes.height;
      const size_t p = inside ? static_cast<size_t>(y + dy) * planes.width + x + dx : 0;
      if (!inside || planes.inverse_depth[p] == 0) {
        taps[k].dd = infinity;
        mask[k] = 0;
        continue;
      }
      taps[k].dd = planes.ray_length[p] / planes.inverse_depth[p] - distance;
      const float predicted = planes.inverse_depth[centre] +
                              static_cast<float>(dx) * planes.slope_x[centre] +
                              static_cast<float>(dy) * planes.slope_y[centre];
      const bool on_plane =
          OnPlane(planes.inverse_depth[p], predicted, planes.inverse_depth[centre], limit);
      all_on_plane = all_on_plane && on_plane;
      if (mode == MaskMode::kPlane) mask[k] = on_plane ? 1 : 0;
    }
  }
  if (mode == MaskMode::kPlane || (mode == MaskMode::kPaper && all_on_plane)) return mask;
  if (mode == MaskMode::kPaper) {
    for (Tap& tap : taps) tap.dd = std::abs(tap.dd);
  }
  double max = -infinity;
  for (const Tap& tap : taps) {
    if (mode == MaskMode::kPaperStrict || std::isfinite(tap.dd)) max = std::max(max, tap.dd);
  }
  const double sigma = PrintedSigma(taps, max);
  for (size_t k = 0; k < mask.size(); ++k) mask[k] = PrintedRule(taps[k].dd, sigma, max) ? 1 : 0;
  return mask;
}

WindowMasks MakeWindowMasks(const DepthPlanes& planes, int radius, MaskMode mode, double plane_px,
                            int min_taps) {
  const int side = 2 * radius + 1;
  WindowMasks masks;
  masks.radius = radius;
  masks.words = (side * side + 63) / 64;
  masks.row_start.assign(planes.height + 1, 0);
  if (mode == MaskMode::kNone) return masks;
  const auto limit = static_cast<float>(plane_px / planes.focal);
  struct RowMasks {
    std::vector<int> column;
    std::vector<uint64_t> bits;
  };
  std::vector<RowMasks> rows(planes.height);
  ParallelFor(planes.height, kRowGrain, [&](int begin, int end) {
    std::vector<char> flags(planes.width);
    std::vector<uint64_t> bits(masks.words);
    for (int y = begin; y < end; ++y) {
      const size_t row = static_cast<size_t>(y) * planes.width;
      if (mode != MaskMode::kPaperStrict) FlagRow(planes, y, radius, limit, &flags);
      for (int x = 0; x < planes.width; ++x) {
        if (planes.inverse_depth[row + x] == 0) continue;
        if (mode != MaskMode::kPaperStrict && flags[x] == 0) continue;
        std::fill(bits.begin(), bits.end(), 0);
        if (mode == MaskMode::kPlane) {
          if (!PlaneBits(planes, x, y, radius, limit, bits.data())) continue;
          rows[y].column.push_back(x);
          rows[y].bits.insert(rows[y].bits.end(), bits.begin(), bits.end());
          continue;
        }
        const std::vector<char> mask = WindowMask(planes, x, y, radius, mode, plane_px);
        bool full = true;
        for (int k = 0; k < side * side; ++k) {
          if (mask[k] != 0) {
            bits[k / 64] |= uint64_t{1} << (k % 64);
            continue;
          }
          const int tap_x = x + k % side - radius;
          const int tap_y = y + k / side - radius;
          full = full &&
                 (tap_x < 0 || tap_x >= planes.width || tap_y < 0 || tap_y >= planes.height ||
                  planes.inverse_depth[static_cast<size_t>(tap_y) * planes.width + tap_x] == 0);
        }
        if (full) continue;
        rows[y].column.push_back(x);
        rows[y].bits.insert(rows[y].bits.end(), bits.begin(), bits.end());
      }
    }
  });
  for (int y = 0; y < planes.height; ++y) {
    masks.column.insert(masks.column.end(), rows[y].column.begin(), rows[y].column.end());
    masks.bits.insert(masks.bits.end(), rows[y].bits.begin(), rows[y].bits.end());
    masks.row_start[y + 1] = static_cast<uint32_t>(masks.column.size());
  }
  FlagThin(planes, min_taps, &masks);
  return masks;
}

}  // namespace burin
