// Derivatives of one row (see costs/pair_kernel.h). Included once per target of the SIMD library.
#if defined(BURIN_COSTS_PAIR_KERNEL_DERIVATIVES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef BURIN_COSTS_PAIR_KERNEL_DERIVATIVES_INL_H_
#undef BURIN_COSTS_PAIR_KERNEL_DERIVATIVES_INL_H_
#else
#define BURIN_COSTS_PAIR_KERNEL_DERIVATIVES_INL_H_
#endif

#include <hwy/highway.h>

#include "costs/kernel_rows.h"
#include "costs/pair_kernel_masked-inl.h"
#include "costs/pair_kernel_windows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Adds cost, slope, curvature and share of the tile's pixels of row y to `fields`; with kPair sets those of
// the pair.
template <int kRadius, bool kPair, typename T>
HWY_ATTR void DifferentiateRow(const PairInput<T>& input, const Tile& tile, int y,
                               KernelRows<T>* rows, PixelFields<T>* fields, PairFields<T>* pair) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const WindowColumns<kRadius, T> sums[5] = {
      {kSumA, y, rows}, {kSumB, y, rows}, {kSumE, y, rows}, {kSumC, y, rows}, {kSumShare, y, rows}};
  const bool has_masks = input.masks != nullptr;
  const MaskedAround<kRadius, T> masked(y, rows);
  const T* HWY_RESTRICT mask = rows->Row(kMask, y);
  const T* HWY_RESTRICT intensity = rows->Row(kI, y);
  const T* HWY_RESTRICT warped = rows->Row(kW, y);
  const T* HWY_RESTRICT slope_w = rows->Row(kD, y);
  const T* HWY_RESTRICT cost = rows->Row(kCost, y);
  T* HWY_RESTRICT sums_here = rows->PixelSums();
  constexpr int kCount = PixelFields<T>::kSumCount;
  for (int x = 0; x < rows->columns; x += lanes) {
    const V dw = hn::Load(d, slope_w + x);
    V a = sums[0].Sum(d, x);
    V b = sums[1].Sum(d, x);
    V e = sums[2].Sum(d, x);
    V c = sums[3].Sum(d, x);
    V tap_share = sums[4].Sum(d, x);
    if (has_masks) masked.Add(d, x, &a, &b, &e, &c, &tap_share);
    // dE/dW; dw is zero outside Omega_ij.
    const V derivative =
        hn::NegMulAdd(hn::Load(d, intensity + x), a, hn::MulAdd(hn::Load(d, warped + x), b, e));
    hn::StoreInterleaved4(hn::Load(d, cost + x), hn::Mul(derivative, dw),
                          hn::Mul(c, hn::Mul(dw, dw)), hn::Mul(tap_share, hn::Load(d, mask + x)), d,
                          sums_here + static_cast<ptrdiff_t>(x) * kCount);
    if (!kPair) continue;
    hn::StoreInterleaved4(derivative, c, hn::Load(d, rows->GradientRow(0, y) + x),
                          hn::Load(d, rows->GradientRow(1, y) + x), d,
                          rows->PairSums() + static_cast<ptrdiff_t>(x) * PairFields<T>::kCount);
  }
  sums_here += static_cast<ptrdiff_t>(tile.x0 - rows->x_begin) * kCount;
  T* HWY_RESTRICT out =
      fields->sums.data() + (static_cast<size_t>(y) * input.width + tile.x0) * kCount;
  for (int k = 0; k < (tile.x1 - tile.x0) * kCount; ++k) out[k] += sums_here[k];
  if (!kPair) return;
  constexpr ptrdiff_t kFields = PairFields<T>::kCount;
  std::copy_n(rows->PairSums() + (tile.x0 - rows->x_begin) * kFields, (tile.x1 - tile.x0) * kFields,
              pair->values.data() + (static_cast<ptrdiff_t>(y) * input.width + tile.x0) * kFields);
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
