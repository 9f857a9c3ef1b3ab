// What the photometric energy holds constant during a round, besides visibility: occlusion masks, the
// pixels left out beside depth steps, the pixels held back, and the tiles in which pairs are worked on.
#pragma once

#include <cstdint>
#include <vector>

#include "core/solve/energy_term.h"
#include "costs/occlusion_mask.h"
#include "costs/pair_kernel.h"
#include "costs/photometric_options.h"

namespace burin {

struct ViewTile {
  Tile tile;
  std::vector<int> partners;  // indices into ViewPartners::seconds with a pixel in the tile
};

// Pairs to evaluate and their pixels, by reference view.
struct PairSample {
  std::vector<const ViewPartners*> partners;
  std::vector<PartnerBits> pixels;  // what is used of Omega_ij; empty = all of it
  std::vector<std::vector<ViewTile>> tiles;

  const PartnerBits& Pixels(size_t view) const {
    return pixels.empty() ? partners[view]->second_visible : pixels[view];
  }
};

struct FrozenWindows {
  std::vector<WindowMasks> masks;  // per view
  PairSample used;                 // the energy's
  PairSample held_back;            // to judge by; empty where the context holds nothing back
  int64_t reference_pixels = 0;    // of all views: windows that could have a mask
  double mask_seconds = 0;
};

// `hold_squares`: the windows of small squares are what is held back, and pairs that the context
// holds back are not looked at. The context must outlive the result.
FrozenWindows FreezeWindows(const RoundContext& context, const PhotometricOptions& options,
                            bool hold_squares);

// Those squares: 6 pixels wide, 48 apart, 1.6 % of the pixels.
inline bool InHeldBackSquare(int x, int y) { return (x + 27) % 48 < 6 && (y + 27) % 48 < 6; }

}  // namespace burin
