// SplineImage::Sample for a vector of points (see costs/pair_kernel.cc). It is included once per target
// of the SIMD library, so it has no include guard in the usual sense.
#if defined(BURIN_COSTS_SPLINE_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef BURIN_COSTS_SPLINE_SIMD_INL_H_
#undef BURIN_COSTS_SPLINE_SIMD_INL_H_
#else
#define BURIN_COSTS_SPLINE_SIMD_INL_H_
#endif

#include <hwy/highway.h>

#include "costs/spline_image.h"

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Cubic B-spline basis at the four samples around a point, t in [0, 1) from the second of them.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void SplineWeights(D d, V t, V w[4]) {
  const V sixth = hn::Set(d, static_cast<hn::TFromD<D>>(1.0 / 6));
  const V u = hn::Sub(hn::Set(d, 1), t);
  const V tt = hn::Mul(t, t);
  w[0] = hn::Mul(hn::Mul(hn::Mul(u, u), u), sixth);
  w[3] = hn::Mul(hn::Mul(tt, t), sixth);
  // 2/3 - t^2 + t^3/2
  w[1] = hn::MulAdd(tt, hn::MulSub(t, hn::Set(d, static_cast<hn::TFromD<D>>(0.5)), hn::Set(d, 1)),
                    hn::Set(d, static_cast<hn::TFromD<D>>(2.0 / 3)));
  w[2] = hn::Sub(hn::Sub(hn::Sub(hn::Set(d, 1), w[0]), w[1]), w[3]);
}

// Its derivative.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void SplineSlopes(D d, V t, V s[4]) {
  const V half = hn::Set(d, static_cast<hn::TFromD<D>>(0.5));
  const V u = hn::Sub(hn::Set(d, 1), t);
  s[0] = hn::Neg(hn::Mul(hn::Mul(u, u), half));
  s[3] = hn::Mul(hn::Mul(t, t), half);
  s[1] = hn::Mul(t, hn::MulSub(t, hn::Set(d, static_cast<hn::TFromD<D>>(1.5)), hn::Set(d, 2)));
  s[2] = hn::Neg(hn::Add(hn::Add(s[0], s[1]), s[3]));
}

// rows[k] = sum over the rows of weight * coefficient of column k, for every point; the same with
// the slopes. By gathering: for double precision, which is for derivative checks.
template <bool kDerivatives, class D, class DI, typename T, class V = hn::Vec<D>>
HWY_INLINE void GatherColumns(D d, DI /*di*/, const T* coefficients, size_t stride,
                              hn::Vec<DI> offset, const V wy[4], const V sy[4], V rows[4],
                              V slopes[4]) {
  for (int k = 0; k < 4; ++k) {
    rows[k] = slopes[k] = hn::Zero(d);
    for (int r = 0; r < 4; ++r) {
      const V value = hn::GatherIndex(d, coefficients + r * stride + k, offset);
      rows[k] = hn::MulAdd(value, wy[r], rows[k]);
      if (kDerivatives) slopes[k] = hn::MulAdd(value, sy[r], slopes[k]);
    }
  }
}

#if HWY_TARGET != HWY_SCALAR

// Four neighbours at each of the points k, k + 4, ... of a vector, one point a block.
template <int k, class D>
HWY_INLINE hn::Vec<D> LoadBlocks(D d, const float* coefficients, const int32_t* at) {
#if HWY_MAX_BYTES < 32
  return hn::LoadU(d, coefficients + at[k]);
#elif HWY_MAX_BYTES < 64
  const hn::Half<D> block;
  return hn::Combine(d, hn::LoadU(block, coefficients + at[k + 4]),
                     hn::LoadU(block, coefficients + at[k]));
#else
  hn::Vec<D> blocks = hn::LoadDup128(d, coefficients + at[k + 12]);
  blocks = hn::IfThenElse(hn::FirstN(d, 12), hn::LoadDup128(d, coefficients + at[k + 8]), blocks);
  blocks = hn::IfThenElse(hn::FirstN(d, 8), hn::LoadDup128(d, coefficients + at[k + 4]), blocks);
  return hn::IfThenElse(hn::FirstN(d, 4), hn::LoadDup128(d, coefficients + at[k]), blocks);
#endif
}

// 4x4 transposition within blocks of four lanes.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void TransposeBlocks(D d, V v[4]) {
  const hn::Repartition<double, D> dd;
  const auto lower01 = hn::BitCast(dd, hn::InterleaveLower(d, v[0], v[1]));
  const auto upper01 = hn::BitCast(dd, hn::InterleaveUpper(d, v[0], v[1]));
  const auto lower23 = hn::BitCast(dd, hn::InterleaveLower(d, v[2], v[3]));
  const auto upper23 = hn::BitCast(dd, hn::InterleaveUpper(d, v[2], v[3]));
  v[0] = hn::BitCast(d, hn::InterleaveLower(dd, lower01, lower23));
  v[1] = hn::BitCast(d, hn::InterleaveUpper(dd, lower01, lower23));
  v[2] = hn::BitCast(d, hn::InterleaveLower(dd, upper01, upper23));
  v[3] = hn::BitCast(d, hn::InterleaveUpper(dd, upper01, upper23));
}

// Adds row r of the coefficients at every point, `row` pointing to it, to GatherColumns' sums.
template <bool kDerivatives, int r, class D, class V = hn::Vec<D>>
HWY_INLINE void AddRow(D d, const float* row, const int32_t* at, const V wy[4], const V sy[4],
                       V rows[4], V slopes[4]) {
  V column[4] = {LoadBlocks<0>(d, row, at), LoadBlocks<1>(d, row, at), LoadBlocks<2>(d, row, at),
                 LoadBlocks<3>(d, row, at)};
  TransposeBlocks(d, column);
  for (int k = 0; k < 4; ++k) {
    rows[k] = r == 0 ? hn::Mul(column[k], wy[0]) : hn::MulAdd(column[k], wy[r], rows[k]);
    if (!kDerivatives) continue;
    slopes[k] = r == 0 ? hn::Mul(column[k], sy[0]) : hn::MulAdd(column[k], sy[r], slopes[k]);
  }
}

// GatherColumns in single precision, where four neighbouring coefficients are one block: four loads
// a point instead of sixteen.
template <bool kDerivatives, class D, class DI, class V = hn::Vec<D>>
HWY_INLINE void LoadColumns(D d, DI di, const float* coefficients, size_t stride,
                            hn::Vec<DI> offset, const V wy[4], const V sy[4], V rows[4],
                            V slopes[4]) {
  alignas(64) int32_t at[hn::MaxLanes(d)];
  hn::Store(offset, di, at);
  AddRow<kDerivatives, 0>(d, coefficients, at, wy, sy, rows, slopes);
  AddRow<kDerivatives, 1>(d, coefficients + stride, at, wy, sy, rows, slopes);
  AddRow<kDerivatives, 2>(d, coefficients + 2 * stride, at, wy, sy, rows, slopes);
  AddRow<kDerivatives, 3>(d, coefficients + 3 * stride, at, wy, sy, rows, slopes);
}

#endif  // HWY_TARGET != HWY_SCALAR

template <bool kDerivatives, class D, class DI, typename T, class V = hn::Vec<D>>
HWY_INLINE void SplineColumns(D d, DI di, const T* coefficients, size_t stride, hn::Vec<DI> offset,
                              const V wy[4], const V sy[4], V rows[4], V slopes[4]) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (sizeof(T) == 4) {
    LoadColumns<kDerivatives>(d, di, coefficients, stride, offset, wy, sy, rows, slopes);
    return;
  }
#endif
  if constexpr (sizeof(T) != 4 || HWY_TARGET == HWY_SCALAR) {
    GatherColumns<kDerivatives>(d, di, coefficients, stride, offset, wy, sy, rows, slopes);
  }
}

// Value and, with kDerivatives, gradient (per pixel) at the image points (x, y) of the lanes in
// `valid`; the others are anything finite. As SplineImage::Sample.
template <bool kDerivatives, class D, class V = hn::Vec<D>, typename T = hn::TFromD<D>>
HWY_INLINE void SampleSpline(D d, const SplineImage<T>& image, V x, V y, hn::Mask<D> valid,
                             V* value, V* gradient_x, V* gradient_y) {
  const hn::RebindToSigned<D> di;
  constexpr T kPadding = SplineImage<T>::kPadding;
  const V low = hn::Set(d, T(2));
  const V shift = hn::Set(d, kPadding - T(0.5));
  const V free_column = hn::IfThenElse(valid, hn::Add(x, shift), low);
  const V free_row = hn::IfThenElse(valid, hn::Add(y, shift), low);
  const V column =
      hn::Min(hn::Max(free_column, low), hn::Set(d, T(image.width() + 2 * kPadding - 3)));
  const V row = hn::Min(hn::Max(free_row, low), hn::Set(d, T(image.height() + 2 * kPadding - 3)));
  // Positive, so that truncation is floor.
  const auto c = hn::ConvertTo(di, column);
  const auto r = hn::ConvertTo(di, row);
  const V tx = hn::Sub(column, hn::ConvertTo(d, c));
  const V ty = hn::Sub(row, hn::ConvertTo(d, r));
  // Of the first of the 4x4 coefficients: one row above and one column left of (c, r).
  hn::Vec<decltype(di)> offset;
  if constexpr (sizeof(T) == 4) {
    const auto stride = static_cast<int32_t>(image.stride());
    offset = hn::Sub(hn::Add(hn::Mul(r, hn::Set(di, stride)), c), hn::Set(di, stride + 1));
  } else {
    const V stride = hn::Set(d, static_cast<T>(image.stride()));
    const V one = hn::Set(d, 1);
    offset = hn::ConvertTo(
        di, hn::MulAdd(hn::Sub(hn::Sub(row, ty), one), stride, hn::Sub(hn::Sub(column, tx), one)));
  }
  V wx[4];
  V wy[4];
  V sx[4];
  V sy[4];
  SplineWeights(d, tx, wx);
  SplineWeights(d, ty, wy);
  if (kDerivatives) {
    SplineSlopes(d, tx, sx);
    SplineSlopes(d, ty, sy);
  }
  V rows[4];
  V slopes[4];
  SplineColumns<kDerivatives>(d, di, image.coefficients(), image.stride(), offset, wy, sy, rows,
                              slopes);
  *value = hn::Add(hn::MulAdd(rows[0], wx[0], hn::Mul(rows[1], wx[1])),
                   hn::MulAdd(rows[2], wx[2], hn::Mul(rows[3], wx[3])));
  if (!kDerivatives) return;
  // Where one coordinate is clamped the value still changes along the other.
  const auto in_columns = hn::Eq(column, free_column);
  const auto in_rows = hn::Eq(row, free_row);
  *gradient_x =
      hn::IfThenElseZero(in_columns, hn::Add(hn::MulAdd(rows[0], sx[0], hn::Mul(rows[1], sx[1])),
                                             hn::MulAdd(rows[2], sx[2], hn::Mul(rows[3], sx[3]))));
  *gradient_y =
      hn::IfThenElseZero(in_rows, hn::Add(hn::MulAdd(slopes[0], wx[0], hn::Mul(slopes[1], wx[1])),
                                          hn::MulAdd(slopes[2], wx[2], hn::Mul(slopes[3], wx[3]))));
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
