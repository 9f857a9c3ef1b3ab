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

// Small squares of a reference view whose windows are held back. The pixels of these windows, which
// reach beyond the squares by a window's radius, are no taps of the energy's windows.
class HeldBackSquares {
 public:
  explicit HeldBackSquares(int window) : radius_(window / 2) {}
  // The window around this pixel is judged by.
  bool Judge(int x, int y) const { return Within(x, 0) && Within(y, 0); }
  // The pixel is a tap of such a window.
  bool Touch(int x, int y) const { return Within(x, radius_) && Within(y, radius_); }

 private:
  static constexpr int kSide = 6;
  // Of a row or column of squares; a fifth of it is touched whatever the window, 4 % of the pixels.
  int Period() const { return 48 * (kSide + 2 * radius_) / 10; }
  bool Within(int x, int margin) const {
    const int period = Period();
    return (x + period / 2 + kSide / 2 + margin) % period < kSide + 2 * margin;
  }

  int radius_;
};

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

// `hold_squares`: the windows of HeldBackSquares are what is held back, and pairs that the context
// holds back are not looked at. The context must outlive the result.
FrozenWindows FreezeWindows(const RoundContext& context, const PhotometricOptions& options,
                            bool hold_squares);

}  // namespace burin
