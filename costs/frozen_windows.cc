#include "costs/frozen_windows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "costs/step_band.h"

namespace burin {
namespace {

constexpr int kTileColumns = 512;
constexpr int kTileRows = 96;

std::vector<ViewTile> CutTiles(const ViewDomain& domain, const PartnerBits& pixels) {
  std::vector<ViewTile> tiles;
  for (int y0 = 0; y0 < domain.height; y0 += kTileRows) {
    for (int x0 = 0; x0 < domain.width; x0 += kTileColumns) {
      ViewTile entry;
      entry.tile = {x0, y0, std::min(domain.width, x0 + kTileColumns),
                    std::min(domain.height, y0 + kTileRows)};
      PartnerBits any(pixels.partners(), 1);
      for (int y = y0; y < entry.tile.y1; ++y) {
        any.Unite(0, pixels, static_cast<size_t>(y) * domain.width + x0, entry.tile.x1 - x0);
      }
      for (size_t b = 0; b < pixels.partners(); ++b) {
        if (any.Test(b, 0)) entry.partners.push_back(static_cast<int>(b));
      }
      if (!entry.partners.empty()) tiles.push_back(std::move(entry));
    }
  }
  return tiles;
}

void HoldBack(const HeldBackSquares& squares, const std::vector<ViewDomain>& domains,
              FrozenWindows* windows) {
  PairSample& used = windows->used;
  if (used.pixels.empty()) {
    for (const ViewDomain& domain : domains) used.pixels.push_back(domain.second_visible);
  }
  for (size_t i = 0; i < domains.size(); ++i) {
    for (int y = 0; y < domains[i].height; ++y) {
      for (int x = 0; x < domains[i].width; ++x) {
        if (!squares.Touch(x, y)) continue;
        used.pixels[i].ClearAll(static_cast<size_t>(y) * domains[i].width + x);
      }
    }
  }
}

void Cut(const std::vector<ViewDomain>& domains, PairSample* sample) {
  const auto count = static_cast<int>(sample->partners.size());
  sample->tiles.resize(count);
  ParallelFor(count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) sample->tiles[i] = CutTiles(domains[i], sample->Pixels(i));
  });
}

}  // namespace

FrozenWindows FreezeWindows(const RoundContext& context, const PhotometricOptions& options,
                            bool hold_squares) {
  const Stopwatch watch;
  const std::vector<ViewDomain>& domains = *context.domains;
  const MaskMode mode = options.mask.mode;
  const int min_taps =
      static_cast<int>(std::ceil(options.min_valid_share * options.window * options.window));
  FrozenWindows windows;
  windows.used.partners = PartnersOf(domains);
  if (context.held_back != nullptr) {
    windows.held_back.partners =
        hold_squares ? windows.used.partners : PartnersOf(*context.held_back);
  }
  windows.masks.assign(domains.size(), WindowMasks());
  const bool band = mode == MaskMode::kPlane && options.mask.band_px > 0 && !context.first_level;
  std::vector<std::vector<uint8_t>> near_steps(domains.size());
  std::vector<Camera> cameras;
  for (size_t i = 0; i < domains.size(); ++i) {
    cameras.push_back((*context.views)[i].camera);
    windows.reference_pixels += static_cast<int64_t>(domains[i].PixelCount());
  }
  const auto freeze = [&](int i) {
    const ViewDomain& domain = domains[i];
    if (domain.PixelCount() == 0 || mode == MaskMode::kNone) return;
    const DepthPlanes planes = MakeDepthPlanes(domain, *context.mesh, cameras[i],
                                               /*ray_lengths=*/mode != MaskMode::kPlane);
    windows.masks[i] =
        MakeWindowMasks(planes, options.window / 2, mode, options.mask.plane_px, min_taps);
    if (!band) return;
    near_steps[i] = NearSteps(planes, OpenBorderPixels(domain, *context.mesh, context.boundary),
                              options.mask.plane_px, options.mask.band_px);
  };
  // Views at the same time: a part of each runs on one thread.
  ParallelFor(static_cast<int>(domains.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) freeze(i);
  });
  if (band) {
    for (PairSample* sample : {&windows.used, &windows.held_back}) {
      if (sample->partners.empty()) continue;
      sample->pixels = WithoutSteps(domains, sample->partners, cameras, *context.mesh, near_steps,
                                    options.mask.evidence);
    }
  }
  if (hold_squares) HoldBack(HeldBackSquares(options.window), domains, &windows);
  Cut(domains, &windows.used);
  Cut(domains, &windows.held_back);
  windows.mask_seconds = watch.Seconds();
  return windows;
}

}  // namespace burin
