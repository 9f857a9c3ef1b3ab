// Window sums and scores of one row (see costs/pair_kernel.h). Included once per target of
// the SIMD library.
//
// Windows are summed along the row, then down. Up to 7x7 both are plain sums. Wider ones are plain sums
// along the row and running sums in double down: what leaves the window is subtracted without a trace.
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

// Windows of radius kRadius; 0 = any, that of the rows.
template <int kRadius, typename T>
HWY_INLINE int Radius(const KernelRows<T>& rows) {
  return kRadius > 0 ? kRadius : rows.radius;
}

// in[-radius] + ... + in[radius] of the lanes there.
template <class D, typename T = hn::TFromD<D>>
HWY_INLINE hn::Vec<D> SumAlong(D d, const T* in, int radius) {
  auto left = hn::LoadU(d, in - radius);
  auto right = hn::LoadU(d, in + radius);
  for (int k = 1; k < radius; ++k) {
    left = hn::Add(left, hn::LoadU(d, in - k));
    right = hn::Add(right, hn::LoadU(d, in + k));
  }
  return hn::Add(hn::Add(left, right), hn::LoadU(d, in));
}

// Take row y of `count` fields from the running sums before it changes, and add it after.
template <typename T>
HWY_ATTR void TakeFromSums(int field, int count, int y, KernelRows<T>* rows) {
  for (int k = field; k < field + count; ++k) {
    const T* HWY_RESTRICT row = rows->Row(k, y);
    double* HWY_RESTRICT running = rows->Running(k);
    for (int x = 0; x < rows->columns; ++x) running[x] -= static_cast<double>(row[x]);
  }
}
template <typename T>
HWY_ATTR void AddToSums(int field, int count, int y, KernelRows<T>* rows) {
  for (int k = field; k < field + count; ++k) {
    const T* HWY_RESTRICT row = rows->Row(k, y);
    double* HWY_RESTRICT running = rows->Running(k);
    for (int x = 0; x < rows->columns; ++x) running[x] += static_cast<double>(row[x]);
  }
}

// The sums along row y that windows need.
template <int kRadius, typename T>
HWY_ATTR void SumRow(int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  constexpr int kCount = 6;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int radius = Radius<kRadius>(*rows);
  const int columns = rows->columns;
  const T* HWY_RESTRICT mask = rows->Row(kMask, y);
  const T* HWY_RESTRICT intensity = rows->Row(kI, y);
  const T* HWY_RESTRICT warped = rows->Row(kW, y);
  T* sums[kCount];
  for (int k = 0; k < kCount; ++k) sums[k] = rows->Row(kSumMask + k, y);
  if (kRadius == 0) TakeFromSums(kSumMask, kCount, y, rows);
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
    for (int k = -radius; k <= radius; ++k) {
      const V i = hn::LoadU(d, intensity + x + k);
      const V w = hn::LoadU(d, warped + x + k);
      sum_i = hn::Add(sum_i, i);
      sum_w = hn::Add(sum_w, w);
      ii = hn::MulAdd(i, i, ii);
      ww = hn::MulAdd(w, w, ww);
      iw = hn::MulAdd(i, w, iw);
    }
    hn::Store(SumAlong(d, mask + x, radius), d, sums[0] + x);
    hn::Store(sum_i, d, sums[1] + x);
    hn::Store(sum_w, d, sums[2] + x);
    hn::Store(ii, d, sums[3] + x);
    hn::Store(ww, d, sums[4] + x);
    hn::Store(iw, d, sums[5] + x);
  }
  if (kRadius == 0) AddToSums(kSumMask, kCount, y, rows);
}

// A field from kSumMask to kSumShare summed over the rows around y: the rows of the window.
template <int kRadius, typename T>
class WindowColumns {
 public:
  WindowColumns(int field, int y, KernelRows<T>* rows) {
    if (kRadius == 0) {
      running_ = rows->Running(field);
      return;
    }
    for (int k = -kRadius; k <= kRadius; ++k) row_[k + kRadius] = rows->Row(field, y + k);
  }
  template <class D>
  HWY_INLINE hn::Vec<D> Sum(D d, int x) const {
    if constexpr (kRadius == 0) {
      alignas(64) T sums[hn::MaxLanes(D())];
      for (size_t k = 0; k < hn::MaxLanes(d); ++k) sums[k] = static_cast<T>(running_[x + k]);
      return hn::Load(d, sums);
    } else {
      auto above = hn::Load(d, row_[0] + x);
      auto below = hn::Load(d, row_[2 * kRadius] + x);
      for (int k = 1; k < kRadius; ++k) {
        above = hn::Add(above, hn::Load(d, row_[k] + x));
        below = hn::Add(below, hn::Load(d, row_[2 * kRadius - k] + x));
      }
      return hn::Add(hn::Add(above, below), hn::Load(d, row_[kRadius] + x));
    }
  }

 private:
  const T* row_[2 * kRadius + 1] = {};
  const double* running_ = nullptr;
};

// Scores the windows of row y: omega, A, B, E, C, share in scratch rows 0 to 5, cost in its field.
template <int kRadius, typename T>
HWY_ATTR void ScoreRow(const PairInput<T>& input, int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const T* HWY_RESTRICT mask = rows->Row(kMask, y);
  T* out[7];
  for (int k = 0; k < 6; ++k) out[k] = rows->Scratch(k);
  out[6] = rows->Row(kCost, y);
  const WindowColumns<kRadius, T> taps(kSumMask, y, rows);
  const WindowColumns<kRadius, T> sum_i(kSumI, y, rows);
  const WindowColumns<kRadius, T> sum_w(kSumW, y, rows);
  const WindowColumns<kRadius, T> sum_ii(kSumII, y, rows);
  const WindowColumns<kRadius, T> sum_ww(kSumWW, y, rows);
  const WindowColumns<kRadius, T> sum_iw(kSumIW, y, rows);
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
template <int kRadius, typename T>
HWY_ATTR void SumScores(int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  constexpr int kCount = KernelRows<T>::kTapFields;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int radius = Radius<kRadius>(*rows);
  if (kRadius == 0) TakeFromSums(kSumA, kCount, y, rows);
  for (int k = 0; k < kCount; ++k) {
    T* HWY_RESTRICT in = rows->Scratch(1 + k);
    std::fill(in + rows->columns, in + rows->columns + 16, T(0));
    T* HWY_RESTRICT out = rows->Row(kSumA + k, y);
    for (int x = 0; x < rows->columns; x += lanes) {
      hn::Store(SumAlong(d, in + x, radius), d, out + x);
    }
  }
  if (kRadius == 0) AddToSums(kSumA, kCount, y, rows);
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
