// Window sums, scores and derivatives of one row (see costs/pair_kernel.h). Included once per target of
// the SIMD library.
//
// 5x5 windows, the common ones, are summed directly: 4 additions along the row and 4 down. Windows
// of other sizes are running sums in double, along the row and down, so that their cost does not
// depend on their size.
#if defined(BURIN_COSTS_PAIR_KERNEL_WINDOWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef BURIN_COSTS_PAIR_KERNEL_WINDOWS_INL_H_
#undef BURIN_COSTS_PAIR_KERNEL_WINDOWS_INL_H_
#else
#define BURIN_COSTS_PAIR_KERNEL_WINDOWS_INL_H_
#endif

#include <hwy/highway.h>

#include "costs/kernel_rows.h"
#include "costs/pair_kernel_warp-inl.h"

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// What follows from the sums over the taps of a window.
template <class V>
struct WindowScores {
  V omega;  // 0 for a window that does not count
  V cost;   // omega (1 - z)
  V a;      // omega / (s_a s_b)
  V b;      // omega z / s_b^2
  V e;      // a mean_I - b mean_W
  V c;      // omega / s_b^2
  V share;  // cost / n
};

template <class D, class V = hn::Vec<D>>
HWY_INLINE WindowScores<V> ScoreWindows(D d, hn::Mask<D> valid, V taps, V sum_i, V sum_w, V sum_ii,
                                        V sum_ww, V sum_iw, V floor, V noise, bool weighted) {
  const V one = hn::Set(d, 1);
  const V zero = hn::Zero(d);
  const V n = hn::IfThenElse(valid, taps, one);
  const V inverse_n = hn::Div(one, n);
  const V mean_i = hn::Mul(sum_i, inverse_n);
  const V mean_w = hn::Mul(sum_w, inverse_n);
  const V variance_i = hn::Max(zero, hn::NegMulAdd(sum_i, mean_i, sum_ii));
  const V variance_w = hn::Max(zero, hn::NegMulAdd(sum_w, mean_w, sum_ww));
  const V covariance = hn::NegMulAdd(sum_i, mean_w, sum_iw);
  const V square_a = hn::MulAdd(n, floor, variance_i);
  const V square_b = hn::MulAdd(n, floor, variance_w);
  const V root = hn::Sqrt(hn::Mul(square_a, square_b));
  const V both = hn::Div(one, hn::Mul(root, square_b));
  const V inverse_ab = hn::Mul(both, square_b);
  const V inverse_bb = hn::Mul(both, root);
  V omega = one;
  if (weighted) omega = hn::Div(square_a, hn::MulAdd(n, noise, square_a));
  omega = hn::IfThenElseZero(valid, omega);
  const V z = hn::Mul(covariance, inverse_ab);
  WindowScores<V> score;
  score.omega = omega;
  score.cost = hn::NegMulAdd(omega, z, omega);
  score.share = hn::Mul(score.cost, inverse_n);
  score.a = hn::Mul(omega, inverse_ab);
  score.c = hn::Mul(omega, inverse_bb);
  score.b = hn::Mul(score.c, z);
  score.e = hn::NegMulAdd(score.b, mean_w, hn::Mul(score.a, mean_i));
  return score;
}

// in[x - 2] + ... + in[x + 2] of the lanes from x.
template <class D, typename T = hn::TFromD<D>>
HWY_INLINE hn::Vec<D> FiveAlong(D d, const T* in) {
  const auto outer = hn::Add(hn::Add(hn::LoadU(d, in - 2), hn::LoadU(d, in - 1)),
                             hn::Add(hn::LoadU(d, in + 1), hn::LoadU(d, in + 2)));
  return hn::Add(outer, hn::LoadU(d, in));
}

// Replaces row y of a field by the sums of `in` along the row and updates the field's running sum
// over the held rows. `in` is readable, and zero, `radius` elements beyond both ends.
template <typename T>
HWY_ATTR void RunAlong(const T* HWY_RESTRICT in, int field, int y, KernelRows<T>* rows) {
  T* HWY_RESTRICT out = rows->Row(field, y);
  double* HWY_RESTRICT running = rows->Running(field);
  const int radius = rows->radius;
  double sum = 0;
  for (int x = -radius; x < radius; ++x) sum += static_cast<double>(in[x]);
  for (int x = 0; x < rows->columns; ++x) {
    sum += static_cast<double>(in[x + radius]);
    running[x] -= static_cast<double>(out[x]);
    out[x] = static_cast<T>(sum);
    running[x] += static_cast<double>(out[x]);
    sum -= static_cast<double>(in[x - radius]);
  }
}

// The sums along row y that windows need.
template <typename T>
HWY_ATTR void SumRow(int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int columns = rows->columns;
  const T* HWY_RESTRICT mask = rows->Row(kMask, y);
  const T* HWY_RESTRICT intensity = rows->Row(kI, y);
  const T* HWY_RESTRICT warped = rows->Row(kW, y);
  if (rows->radius != 2) {
    T* products[3] = {rows->Scratch(0), rows->Scratch(1), rows->Scratch(2)};
    for (int x = 0; x < columns; ++x) {
      products[0][x] = intensity[x] * intensity[x];
      products[1][x] = warped[x] * warped[x];
      products[2][x] = intensity[x] * warped[x];
    }
    // Vectors may have written beyond the columns.
    for (T* product : products) std::fill(product + columns, product + columns + 16, T(0));
    RunAlong(mask, kSumMask, y, rows);
    RunAlong(intensity, kSumI, y, rows);
    RunAlong(warped, kSumW, y, rows);
    RunAlong(products[0], kSumII, y, rows);
    RunAlong(products[1], kSumWW, y, rows);
    RunAlong(products[2], kSumIW, y, rows);
    return;
  }
  T* sums[6];
  for (int k = 0; k < 6; ++k) sums[k] = rows->Row(kSumMask + k, y);
  if (rows->Used(y) == 0) {
    for (T* sum : sums) std::fill(sum, sum + columns, T(0));
    return;
  }
  for (int x = 0; x < columns; x += lanes) {
    V ii = hn::Zero(d);
    V ww = hn::Zero(d);
    V iw = hn::Zero(d);
    V sum_i = hn::Zero(d);
    V sum_w = hn::Zero(d);
    for (int k = -2; k <= 2; ++k) {
      const V i = hn::LoadU(d, intensity + x + k);
      const V w = hn::LoadU(d, warped + x + k);
      sum_i = hn::Add(sum_i, i);
      sum_w = hn::Add(sum_w, w);
      ii = hn::MulAdd(i, i, ii);
      ww = hn::MulAdd(w, w, ww);
      iw = hn::MulAdd(i, w, iw);
    }
    hn::Store(FiveAlong(d, mask + x), d, sums[0] + x);
    hn::Store(sum_i, d, sums[1] + x);
    hn::Store(sum_w, d, sums[2] + x);
    hn::Store(ii, d, sums[3] + x);
    hn::Store(ww, d, sums[4] + x);
    hn::Store(iw, d, sums[5] + x);
  }
}

// A field from kSumMask to kSumShare summed over the rows around y: the rows of the window.
template <typename T>
class WindowColumns {
 public:
  WindowColumns(int field, int y, KernelRows<T>* rows) {
    if (rows->radius == 2) {
      for (int k = 0; k < 5; ++k) row_[k] = rows->Row(field, y - 2 + k);
    } else {
      running_ = rows->Running(field);
    }
  }
  template <class D>
  HWY_INLINE hn::Vec<D> Sum(D d, int x) const {
    if (running_ == nullptr) {
      const auto outer = hn::Add(hn::Add(hn::Load(d, row_[0] + x), hn::Load(d, row_[1] + x)),
                                 hn::Add(hn::Load(d, row_[3] + x), hn::Load(d, row_[4] + x)));
      return hn::Add(outer, hn::Load(d, row_[2] + x));
    }
    alignas(64) T sums[16];
    for (size_t k = 0; k < hn::Lanes(d); ++k) sums[k] = static_cast<T>(running_[x + k]);
    return hn::Load(d, sums);
  }

 private:
  const T* row_[5] = {};
  const double* running_ = nullptr;
};

// Scores the windows of row y: omega, A, B, E, C, share in scratch rows 0 to 5, cost in its field.
template <typename T>
HWY_ATTR void ScoreRow(const PairInput<T>& input, int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const T* HWY_RESTRICT mask = rows->Row(kMask, y);
  T* out[7];
  for (int k = 0; k < 6; ++k) out[k] = rows->Scratch(k);
  out[6] = rows->Row(kCost, y);
  const WindowColumns<T> taps(kSumMask, y, rows);
  const WindowColumns<T> sum_i(kSumI, y, rows);
  const WindowColumns<T> sum_w(kSumW, y, rows);
  const WindowColumns<T> sum_ii(kSumII, y, rows);
  const WindowColumns<T> sum_ww(kSumWW, y, rows);
  const WindowColumns<T> sum_iw(kSumIW, y, rows);
  const V floor = hn::Set(d, static_cast<T>(input.variance_floor));
  const V noise = hn::Set(d, static_cast<T>(input.reliability_noise));
  const bool weighted = input.reliability_noise > 0;
  const V min_taps = hn::Set(d, static_cast<T>(input.min_taps));
  const V zero = hn::Zero(d);
  for (int x = 0; x < rows->columns; x += lanes) {
    const V n = taps.Sum(d, x);
    const auto valid = hn::And(hn::Gt(hn::Load(d, mask + x), zero), hn::Ge(n, min_taps));
    if (hn::AllFalse(d, valid)) {
      for (T* row : out) hn::Store(zero, d, row + x);
      continue;
    }
    const WindowScores<V> score =
        ScoreWindows(d, valid, n, sum_i.Sum(d, x), sum_w.Sum(d, x), sum_ii.Sum(d, x),
                     sum_ww.Sum(d, x), sum_iw.Sum(d, x), floor, noise, weighted);
    hn::Store(score.omega, d, out[0] + x);
    hn::Store(score.a, d, out[1] + x);
    hn::Store(score.b, d, out[2] + x);
    hn::Store(score.e, d, out[3] + x);
    hn::Store(score.c, d, out[4] + x);
    hn::Store(score.share, d, out[5] + x);
    hn::Store(score.cost, d, out[6] + x);
  }
}

// Sums A, B, E, C and share of row y, in scratch rows 1 to 5, along the row.
template <typename T>
HWY_ATTR void SumScores(int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int k = 0; k < KernelRows<T>::kTapFields; ++k) {
    T* HWY_RESTRICT in = rows->Scratch(1 + k);
    std::fill(in + rows->columns, in + rows->columns + 16, T(0));
    if (rows->radius != 2) {
      RunAlong(in, kSumA + k, y, rows);
      continue;
    }
    T* HWY_RESTRICT out = rows->Row(kSumA + k, y);
    for (int x = 0; x < rows->columns; x += lanes) hn::Store(FiveAlong(d, in + x), d, out + x);
  }
}

// Adds cost, slope, curvature and share of the tile's pixels of row y to `fields`.
template <typename T>
HWY_ATTR void DifferentiateRow(const PairInput<T>& input, const Tile& tile, int y,
                               KernelRows<T>* rows, PixelFields<T>* fields) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const WindowColumns<T> sums[5] = {
      {kSumA, y, rows}, {kSumB, y, rows}, {kSumE, y, rows}, {kSumC, y, rows}, {kSumShare, y, rows}};
  const bool direct = rows->Direct(y) != 0;
  const T* HWY_RESTRICT direct_a = rows->Row(kDirectA, y);
  const T* HWY_RESTRICT direct_b = rows->Row(kDirectB, y);
  const T* HWY_RESTRICT direct_e = rows->Row(kDirectE, y);
  const T* HWY_RESTRICT direct_c = rows->Row(kDirectC, y);
  const T* HWY_RESTRICT direct_share = rows->Row(kDirectShare, y);
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
    if (direct) {
      a = hn::Add(a, hn::Load(d, direct_a + x));
      b = hn::Add(b, hn::Load(d, direct_b + x));
      e = hn::Add(e, hn::Load(d, direct_e + x));
      c = hn::Add(c, hn::Load(d, direct_c + x));
      tap_share = hn::Add(tap_share, hn::Load(d, direct_share + x));
    }
    // dE/dW; dw is zero outside Omega_ij.
    const V derivative =
        hn::NegMulAdd(hn::Load(d, intensity + x), a, hn::MulAdd(hn::Load(d, warped + x), b, e));
    hn::StoreInterleaved4(hn::Load(d, cost + x), hn::Mul(derivative, dw),
                          hn::Mul(c, hn::Mul(dw, dw)), hn::Mul(tap_share, hn::Load(d, mask + x)), d,
                          sums_here + static_cast<ptrdiff_t>(x) * kCount);
  }
  sums_here += static_cast<ptrdiff_t>(tile.x0 - rows->x_begin) * kCount;
  T* HWY_RESTRICT out =
      fields->sums.data() + (static_cast<size_t>(y) * input.width + tile.x0) * kCount;
  for (int k = 0; k < (tile.x1 - tile.x0) * kCount; ++k) out[k] += sums_here[k];
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
