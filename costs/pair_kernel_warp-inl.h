// WarpRow: the second image warped through the surface, for one row of the reference image (see
// costs/pair_kernel.h). Included once per target of the SIMD library.
#if defined(BURIN_COSTS_PAIR_KERNEL_WARP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef BURIN_COSTS_PAIR_KERNEL_WARP_INL_H_
#undef BURIN_COSTS_PAIR_KERNEL_WARP_INL_H_
#else
#define BURIN_COSTS_PAIR_KERNEL_WARP_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

#include "costs/kernel_rows.h"
#include "costs/spline_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most sixteen lanes: as far as rows are readable beyond their columns.
template <typename T>
using KernelTag = hn::CappedTag<T, 16>;

// Fills kMask, kI, kW and, with kDerivatives, kD of row y; with kGradients GradientRow() too.
template <bool kDerivatives, bool kGradients, typename T>
HWY_ATTR void WarpRow(const PairInput<T>& input, int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int columns = rows->columns;
  T* HWY_RESTRICT mask = rows->Row(kMask, y);
  unsigned int any = 0;
  const int lead = std::max(0, -rows->x_begin);  // columns left of the image
  const int stop = std::min(columns, input.width - rows->x_begin);
  std::fill(mask, mask + columns, T(0));
  const size_t first = static_cast<size_t>(std::max(0, y)) * input.width + lead + rows->x_begin;
  if (y >= 0 && y < input.height) {
    const uint8_t* domain = input.domain.bytes + first;
    for (int x = lead; x < stop; ++x) {
      const unsigned int in = domain[x - lead] & input.domain.bit;
      mask[x] = in != 0 ? T(1) : T(0);
      any |= in;
    }
  }
  T* HWY_RESTRICT intensity = rows->Row(kI, y);
  T* HWY_RESTRICT warped = rows->Row(kW, y);
  T* HWY_RESTRICT slope = rows->Row(kD, y);
  rows->Used(y) = any != 0 ? 1 : 0;
  if (any == 0) {
    std::fill(intensity, intensity + columns, T(0));
    std::fill(warped, warped + columns, T(0));
    std::fill(slope, slope + columns, T(0));
    return;  // gradients are read in Omega_ij alone
  }

  // Copies, because vectors may read beyond the row.
  T* HWY_RESTRICT depth = rows->Scratch(0);
  std::copy(input.inverse_depth + first, input.inverse_depth + first + (stop - lead), depth + lead);
  std::copy(input.image + first, input.image + first + (stop - lead), intensity + lead);

  // Homogeneous warp, the row's start in double, increments in T.
  const double* a = input.warp;
  const double xc = rows->x_begin + 0.5;
  const double yc = y + 0.5;
  const V bx = hn::Set(d, static_cast<T>(a[0] * xc + a[1] * yc + a[2]));
  const V by = hn::Set(d, static_cast<T>(a[3] * xc + a[4] * yc + a[5]));
  const V bz = hn::Set(d, static_cast<T>(a[6] * xc + a[7] * yc + a[8]));
  const V ix = hn::Set(d, static_cast<T>(a[0]));
  const V iy = hn::Set(d, static_cast<T>(a[3]));
  const V iz = hn::Set(d, static_cast<T>(a[6]));
  const V ex = hn::Set(d, static_cast<T>(input.epipole[0]));
  const V ey = hn::Set(d, static_cast<T>(input.epipole[1]));
  const V ez = hn::Set(d, static_cast<T>(input.epipole[2]));
  const V offset = hn::Set(d, static_cast<T>(input.grey_offset));
  const V zero = hn::Zero(d);
  for (int x = 0; x < columns; x += lanes) {
    const auto valid = hn::Gt(hn::Load(d, mask + x), zero);
    if (hn::AllFalse(d, valid)) {
      hn::Store(zero, d, intensity + x);
      hn::Store(zero, d, warped + x);
      hn::Store(zero, d, slope + x);
      continue;
    }
    const V s = hn::Load(d, depth + x);
    const V column = hn::Iota(d, static_cast<T>(x));
    const V inverse = hn::Div(hn::Set(d, T(1)), hn::MulAdd(ez, s, hn::MulAdd(iz, column, bz)));
    const V qx = hn::Mul(hn::MulAdd(ex, s, hn::MulAdd(ix, column, bx)), inverse);
    const V qy = hn::Mul(hn::MulAdd(ey, s, hn::MulAdd(iy, column, by)), inverse);
    hn::Store(hn::IfThenElseZero(valid, hn::Sub(hn::Load(d, intensity + x), offset)), d,
              intensity + x);
    V value;
    V gx;
    V gy;
    SampleSpline<kDerivatives>(d, *input.second, qx, qy, valid, &value, &gx, &gy);
    hn::Store(hn::IfThenElseZero(valid, value), d, warped + x);
    if (!kDerivatives) continue;
    const V dx = hn::NegMulAdd(qx, ez, ex);
    const V dy = hn::NegMulAdd(qy, ez, ey);
    const V derivative = hn::Mul(hn::MulAdd(gx, dx, hn::Mul(gy, dy)), inverse);
    hn::Store(hn::IfThenElseZero(valid, derivative), d, slope + x);
    if (!kGradients) continue;
    hn::Store(gx, d, rows->GradientRow(0, y) + x);
    hn::Store(gy, d, rows->GradientRow(1, y) + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
