// One tile of one pair, compiled for every target of the SIMD library (Highway) and dispatched at
// run time. The stages of a row are in the *-inl.h files.
#include "costs/pair_kernel.h"

#include "costs/kernel_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "costs/pair_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "costs/pair_kernel_derivatives-inl.h"
#include "costs/pair_kernel_masked-inl.h"
#include "costs/pair_kernel_warp-inl.h"
#include "costs/pair_kernel_windows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {

// The number of the tile's windows of row y that count. Adds their weights to `fields` and, without
// derivatives, their costs.
template <bool kDerivatives, typename T>
HWY_ATTR int64_t AddCosts(const PairInput<T>& input, const Tile& tile, int y, KernelRows<T>* rows,
                          PixelFields<T>* fields) {
  const int begin = tile.x0 - rows->x_begin;
  const int count = tile.x1 - tile.x0;
  const size_t first = static_cast<size_t>(y) * input.width + tile.x0;
  const T* HWY_RESTRICT omega = rows->Scratch(0) + begin;
  int counted = 0;
  for (int x = 0; x < count; ++x) counted += omega[x] > T(0) ? 1 : 0;
  if (!kDerivatives) {
    const T* HWY_RESTRICT window_cost = rows->Row(kCost, y) + begin;
    T* HWY_RESTRICT cost = fields->sums.data() + first;
    for (int x = 0; x < count; ++x) cost[x] += window_cost[x];
  }
  if (!fields->weight.empty()) {
    T* HWY_RESTRICT weight = fields->weight.data() + first;
    for (int x = 0; x < count; ++x) weight[x] += omega[x];
  }
  return counted;
}

enum class Wanted { kCost, kDerivatives, kPair };

// kRadius: of the windows where they are common, else 0.
template <Wanted kWanted, int kRadius, typename T>
HWY_ATTR int64_t AddRows(const PairInput<T>& input, const Tile& tile, KernelRows<T>* rows,
                         PixelFields<T>* fields, PairFields<T>* pair) {
  constexpr bool kDerivatives = kWanted != Wanted::kCost;
  constexpr bool kPair = kWanted == Wanted::kPair;
  const int radius = input.radius;
  const int halo = kDerivatives ? 2 * radius : radius;
  const bool has_masks = input.masks != nullptr;
  rows->Begin(tile, radius, has_masks, kPair);
  int64_t counted = 0;
  for (int y = tile.y0 - halo; y < tile.y1 + halo; ++y) {
    WarpRow<kDerivatives, kPair>(input, y, rows);
    SumRow<kRadius>(y, rows);
    const int scored = y - radius;
    if (scored < tile.y0 - (halo - radius) || scored >= tile.y1 + (halo - radius)) continue;
    if (has_masks) rows->ClearMasked(scored);
    if (rows->Used(scored) != 0) {
      ScoreRow<kRadius>(input, scored, rows);
      if (has_masks) ScoreMaskedWindows<kRadius>(input, scored, rows);
      if (scored >= tile.y0 && scored < tile.y1) {
        counted += AddCosts<kDerivatives>(input, tile, scored, rows, fields);
      }
    } else {
      for (int k = 0; k < 6; ++k) {
        std::fill(rows->Scratch(k), rows->Scratch(k) + rows->columns, T(0));
      }
    }
    if (!kDerivatives) continue;
    SumScores<kRadius>(scored, rows);
    const int done = scored - radius;
    if (done >= tile.y0 && done < tile.y1 && rows->Used(done) != 0) {
      DifferentiateRow<kRadius, kPair>(input, tile, done, rows, fields, pair);
    }
  }
  return counted;
}

template <Wanted kWanted, typename T>
int64_t AddTileRows(const PairInput<T>& input, const Tile& tile, KernelRows<T>* rows,
                    PixelFields<T>* fields, PairFields<T>* pair) {
  switch (input.radius) {
    case 1:
      return AddRows<kWanted, 1>(input, tile, rows, fields, pair);
    case 2:
      return AddRows<kWanted, 2>(input, tile, rows, fields, pair);
    case 3:
      return AddRows<kWanted, 3>(input, tile, rows, fields, pair);
    default:
      return AddRows<kWanted, 0>(input, tile, rows, fields, pair);
  }
}

template <typename T>
int64_t AddTileIn(const PairInput<T>& input, const Tile& tile, bool derivatives,
                  KernelRows<T>* rows, PixelFields<T>* fields, PairFields<T>* pair) {
  if (pair != nullptr) return AddTileRows<Wanted::kPair>(input, tile, rows, fields, pair);
  return derivatives ? AddTileRows<Wanted::kDerivatives>(input, tile, rows, fields, pair)
                     : AddTileRows<Wanted::kCost>(input, tile, rows, fields, pair);
}

// What the dispatch tables point to: no templates there.
int64_t AddTileFloat(const PairInput<float>& input, const Tile& tile, bool derivatives,
                     KernelRows<float>* rows, PixelFields<float>* fields, PairFields<float>* pair) {
  return AddTileIn(input, tile, derivatives, rows, fields, pair);
}
int64_t AddTileDouble(const PairInput<double>& input, const Tile& tile, bool derivatives,
                      KernelRows<double>* rows, PixelFields<double>* fields,
                      PairFields<double>* pair) {
  return AddTileIn(input, tile, derivatives, rows, fields, pair);
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace burin {

HWY_EXPORT(AddTileFloat);
HWY_EXPORT(AddTileDouble);
HWY_EXPORT(TargetName);

std::string KernelInstructionSet() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

template <typename T>
void PixelFields<T>::Resize(size_t size, bool derivatives, bool weights) {
  per_pixel = derivatives ? kSumCount : 1;
  sums.resize(size * per_pixel);
  weight.resize(weights ? size : 0);
}

template <typename T>
void PixelFields<T>::Clear(size_t begin, size_t end) {
  std::fill(sums.data() + begin * per_pixel, sums.data() + end * per_pixel, T(0));
  if (!weight.empty()) std::fill(weight.data() + begin, weight.data() + end, T(0));
}

template <typename T>
PairKernel<T>::PairKernel() : rows_(std::make_unique<KernelRows<T>>()) {}
template <typename T>
PairKernel<T>::~PairKernel() = default;

template <typename T>
int64_t PairKernel<T>::AddTile(const PairInput<T>& input, const Tile& tile, bool derivatives,
                               PixelFields<T>* fields, PairFields<T>* pair) {
  if constexpr (sizeof(T) == sizeof(float)) {
    return HWY_DYNAMIC_DISPATCH(AddTileFloat)(input, tile, derivatives, rows_.get(), fields, pair);
  } else {
    return HWY_DYNAMIC_DISPATCH(AddTileDouble)(input, tile, derivatives, rows_.get(), fields, pair);
  }
}

template class PairKernel<float>;
template class PairKernel<double>;
template struct PixelFields<float>;
template struct PixelFields<double>;

}  // namespace burin
#endif  // HWY_ONCE
