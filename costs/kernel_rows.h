// The rows that one thread holds while it streams a tile through costs/pair_kernel.h.
//
// Every field is a ring of the last 2 radius + 1 rows: enough for the window sums of a row and for
// the sums over windows of the row 2 radius above it. At 5x5 windows and 512 columns that is about
// 200 KiB, which stays in the second-level cache; nothing per pair ever reaches memory.
#pragma once

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "costs/pair_kernel.h"

namespace burin {

// Fields held as rows. Zero outside Omega_ij.
enum KernelField {
  kMask,  // 1 in Omega_ij
  kI,     // I
  kW,     // W
  kD,     // dW/ds
  kCost,  // omega (1 - z)
  // Horizontal sums over the taps of a window row.
  kSumMask,
  kSumI,
  kSumW,
  kSumII,
  kSumWW,
  kSumIW,
  // Horizontal sums over windows of what dE/dW needs.
  kSumA,      // A = omega / (s_a s_b)
  kSumB,      // B = omega z / s_b^2
  kSumE,      // A mean_I - B mean_W
  kSumC,      // omega / s_b^2
  kSumShare,  // omega (1 - z) / n: a tap's share of the window's cost
  // The same five, already added up per tap, of the windows that have a mask.
  kDirectA,
  kDirectB,
  kDirectE,
  kDirectC,
  kDirectShare,
  kKernelFieldCount
};

template <typename T>
struct KernelRows {
  // Elements before and after the columns of a row that may be read: as far as a window reaches,
  // and a vector more. Zero.
  static constexpr int kPad = 32;
  static constexpr int kScratchRows = 6;
  static constexpr int kSums = 11;  // fields from kSumMask to kSumShare
  static constexpr int kTapFields =
      5;  // from kSumA to kSumShare, and from kDirectA to kDirectShare

  // Sizes the rows for a tile and clears them.
  void Begin(const Tile& tile, int window_radius) {
    radius = window_radius;
    x_begin = tile.x0 - 2 * radius;
    y_begin = tile.y0 - 3 * radius;
    columns = tile.x1 - tile.x0 + 4 * radius;
    ring = 2 * radius + 1;
    stride = (static_cast<size_t>(columns) + 15) / 16 * 16 + 2 * size_t{kPad};
    const size_t lines = static_cast<size_t>(kKernelFieldCount) * ring + kScratchRows;
    const size_t needed = (lines + PixelFields<T>::kSumCount) * stride;
    if (needed > capacity) {
      memory = hwy::AllocateAligned<T>(needed);
      capacity = needed;
    }
    std::fill(memory.get(), memory.get() + needed, T(0));
    used.assign(ring, 0);
    direct.assign(ring, 0);
    if (radius != 2) running.assign(kSums * stride, 0.0);
  }

  // Element 0 of row y of a field; the last `ring` rows are held.
  T* Row(int field, int y) { return Line(static_cast<size_t>(field) * ring + Slot(y)); }
  T* Scratch(int k) { return Line(static_cast<size_t>(kKernelFieldCount) * ring + k); }
  // Room for PixelFields::kSumCount numbers an element.
  T* PixelSums() { return Scratch(kScratchRows); }
  // Sum of the held rows of a field from kSumMask to kSumShare (windows of other radii than 2).
  double* Running(int field) { return running.data() + (field - kSumMask) * stride; }
  char& Used(int y) { return used[Slot(y)]; }
  char& Direct(int y) { return direct[Slot(y)]; }

  int radius = 0;
  int x_begin = 0;  // column of the reference image that element 0 of every row stands for
  int y_begin = 0;  // first row of the reference image that is held
  int columns = 0;
  int ring = 0;
  std::vector<double> running;
  // Masked windows of the row in work: column, entry of WindowMasks, sums over taps about the
  // centre's values (n, I, W, II, WW, IW; then omega, cost, a, b, e, c, share), and those values.
  std::vector<int> masked_column;
  std::vector<size_t> masked_entry;
  std::vector<T> masked_sums[7];
  std::vector<T> masked_centre[2];

 private:
  size_t Slot(int y) const { return static_cast<size_t>((y - y_begin) % ring); }
  T* Line(size_t line) { return memory.get() + line * stride + kPad; }

  size_t stride = 0;
  size_t capacity = 0;
  hwy::AlignedFreeUniquePtr<T[]> memory;
  std::vector<char> used;    // the row has a pixel in Omega_ij
  std::vector<char> direct;  // the row's kDirect fields are not all zero
};

}  // namespace burin
