// The rows that one thread holds while it streams a tile through costs/pair_kernel.h.
//
// Every field is a ring of the last 2 radius + 1 rows: enough for the window sums of a row and for
// the sums over windows of the row 2 radius above it. At 5x5 windows and 512 columns that is about
// 250 KiB, which stays in the second-level cache; nothing per pair ever reaches memory.
#pragma once

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cstdint>
#include <type_traits>
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
  // The same five of single windows: of those that have a mask.
  kMaskedA,
  kMaskedB,
  kMaskedE,
  kMaskedC,
  kMaskedShare,
  kKernelFieldCount
};

template <typename T>
struct KernelRows {
  using Bits = std::conditional_t<sizeof(T) == 4, int32_t, int64_t>;
  // Elements before and after the columns of a row that may be read: as far as a window reaches,
  // and a vector more. Zero.
  static constexpr int kPad = 32;
  static constexpr int kBlock = 16;  // columns; of masked windows. As many as a vector at most has
  static constexpr int kScratchRows = 6;
  static constexpr int kSums = 11;      // fields from kSumMask to kSumShare
  static constexpr int kTapFields = 5;  // from kSumA to kSumShare, from kMaskedA to kMaskedShare

  // Sizes the rows for a tile and clears them. `masked`: some windows may have a mask; `gradients`: with
  // GradientRow() and PairSums().
  void Begin(const Tile& tile, int window_radius, bool masked, bool gradients) {
    radius = window_radius;
    x_begin = tile.x0 - 2 * radius;
    y_begin = tile.y0 - 3 * radius;
    columns = tile.x1 - tile.x0 + 4 * radius;
    ring = 2 * radius + 1;
    stride = (static_cast<size_t>(columns) + 15) / 16 * 16 + 2 * size_t{kPad};
    const size_t lines =
        static_cast<size_t>(kKernelFieldCount) * ring + kScratchRows + PixelFields<T>::kSumCount;
    const size_t more = gradients ? PairFields<T>::kCount + 2 * static_cast<size_t>(ring) : 0;
    memory.Clear((lines + more) * stride);
    slots.resize(tile.y1 - tile.y0 + 6 * radius);
    for (size_t k = 0; k < slots.size(); ++k) slots[k] = static_cast<int>(k) % ring;
    used.assign(ring, 0);
    if (RowsAreSummed()) running.assign(kSums * stride, 0.0);
    words = radius > kOneWord ? ring : 1;
    blocks = columns / kBlock + 3;
    has_masked.assign(ring, 0);
    if (!masked) return;
    bits.Clear(static_cast<size_t>(ring) * (words + 1) * stride);
    masked_blocks.assign(2 * static_cast<size_t>(ring) * blocks, 0);
  }

  // Windows wider than seven have their rows summed up as they come.
  bool RowsAreSummed() const { return radius > 3; }

  // Element 0 of row y of a field; the last `ring` rows are held.
  T* Row(int field, int y) { return Line(static_cast<size_t>(field) * ring + Slot(y)); }
  T* Scratch(int k) { return Line(static_cast<size_t>(kKernelFieldCount) * ring + k); }
  // Room for PixelFields::kSumCount numbers an element.
  T* PixelSums() { return Scratch(kScratchRows); }
  // Room for PairFields::kCount numbers an element; the gradient of W in the second image along x (k = 0)
  // and y (1) in row y.
  T* PairSums() { return Scratch(kScratchRows + PixelFields<T>::kSumCount); }
  T* GradientRow(int k, int y) {
    return Scratch(kScratchRows + PixelFields<T>::kSumCount + PairFields<T>::kCount + k * ring +
                   static_cast<int>(Slot(y)));
  }
  // Sum of the held rows of a field from kSumMask to kSumShare where RowsAreSummed().
  double* Running(int field) { return running.data() + (field - kSumMask) * stride; }
  char& Used(int y) { return used[Slot(y)]; }

  // Of the windows of row y that have a mask, where there may be any:
  // there is one in the row;
  char& HasMasked(int y) { return has_masked[Slot(y)]; }
  // per block of columns, from the block before column 0 on: there is one in it; one reaches into it;
  char* MaskedBlocks(int y) { return &masked_blocks[2 * Slot(y) * blocks] + 1; }
  char* ReachedBlocks(int y) { return MaskedBlocks(y) + blocks; }
  // their taps, 0 for other windows: bits in row-major order in word 0 up to radius kOneWord, else those of
  // window row k in word k;
  static constexpr int kOneWord = 2;
  Bits* Taps(int k, int y) { return Word(k, y); }
  // 0 for other windows, kWindowMasked for them, kWindowFull too where few taps leave it full;
  Bits* Masked(int y) { return Word(words, y); }
  static constexpr Bits kWindowMasked = 1;
  static constexpr Bits kWindowFull = 2;
  // Takes the masked windows from the row's place in the ring. What the kMasked fields have is left: it
  // counts only where a tap is set.
  void ClearMasked(int y) {
    if (HasMasked(y) == 0) return;
    HasMasked(y) = 0;
    char* block = MaskedBlocks(y);
    for (int b = 0; b * kBlock < columns; ++b) {
      if (block[b] == 0) continue;
      for (int k = 0; k <= words; ++k) std::fill_n(Word(k, y) + b * kBlock, kBlock, Bits(0));
    }
    std::fill_n(block - 1, 2 * blocks, static_cast<char>(0));
  }

  int radius = 0;
  int x_begin = 0;  // column of the reference image that element 0 of every row stands for
  int y_begin = 0;  // first row of the reference image that is held
  int columns = 0;
  int ring = 0;
  int words = 0;  // a window
  int blocks = 0;

 private:
  template <typename U>
  struct Memory {
    void Clear(size_t needed) {
      if (needed > capacity) {
        values = hwy::AllocateAligned<U>(needed);
        capacity = needed;
      }
      std::fill(values.get(), values.get() + needed, U(0));
    }
    hwy::AlignedFreeUniquePtr<U[]> values;
    size_t capacity = 0;
  };

  size_t Slot(int y) const { return static_cast<size_t>(slots[y - y_begin]); }
  T* Line(size_t line) { return memory.values.get() + line * stride + kPad; }
  Bits* Word(int k, int y) {
    return bits.values.get() + (Slot(y) * (words + 1) + k) * stride + kPad;
  }

  size_t stride = 0;
  Memory<T> memory;
  Memory<Bits> bits;
  std::vector<double> running;
  std::vector<int> slots;  // of the rows in the ring, from y_begin on
  std::vector<char> used;  // the row has a pixel in Omega_ij
  std::vector<char> has_masked;
  std::vector<char> masked_blocks;
};

}  // namespace burin
