// Windows that lost taps to an occlusion mask: summed and spread tap by tap (see costs/pair_kernel.h).
// A row of taps is one vector for windows up to 8 wide. Included once per target of the SIMD library.
#if defined(BURIN_COSTS_PAIR_KERNEL_MASKED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef BURIN_COSTS_PAIR_KERNEL_MASKED_INL_H_
#undef BURIN_COSTS_PAIR_KERNEL_MASKED_INL_H_
#else
#define BURIN_COSTS_PAIR_KERNEL_MASKED_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "costs/kernel_rows.h"
#include "costs/pair_kernel_windows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The taps of row r of a window that its mask keeps: bit k = tap k from the left.
inline uint32_t RowBits(const WindowMasks& masks, size_t entry, int side, int r) {
  const int begin = side * r;
  const uint64_t* words = masks.bits.data() + entry * masks.words + begin / 64;
  const int shift = begin % 64;
  uint64_t bits = words[0] >> shift;
  if (shift + side > 64) bits |= words[1] << (64 - shift);
  return static_cast<uint32_t>(bits & ((uint64_t{1} << side) - 1));
}

// The lanes whose bit is set.
template <class D>
HWY_INLINE hn::Mask<D> LanesOf(D d, uint32_t bits) {
  const hn::RebindToSigned<D> di;
  using TI = hn::TFromD<decltype(di)>;
  alignas(64) static constexpr TI kLaneBit[16] = {
      1,      2,      4,       8,       16,      32,      64,      128,
      1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15};
  return hn::RebindMask(d, hn::TestBit(hn::Set(di, static_cast<TI>(bits)), hn::Load(di, kLaneBit)));
}

// Lists the masked windows of row y that lie in Omega_ij, with the sums over their taps about the
// values of their centre, which loses fewer digits.
template <typename T>
HWY_ATTR void SumMaskedWindows(const PairInput<T>& input, int y, KernelRows<T>* rows) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const WindowMasks& masks = *input.masks;
  const int radius = input.radius;
  const int side = 2 * radius + 1;
  rows->masked_column.clear();
  rows->masked_entry.clear();
  if (y < 0 || y >= input.height) return;
  const int* columns = masks.column.data();
  const size_t row_end = masks.row_start[y + 1];
  size_t entry = static_cast<size_t>(
      std::lower_bound(columns + masks.row_start[y], columns + row_end, rows->x_begin + radius) -
      columns);
  const T* mask_rows[31];
  const T* i_rows[31];
  const T* w_rows[31];
  for (int r = 0; r < side; ++r) {
    mask_rows[r] = rows->Row(kMask, y - radius + r) - radius;
    i_rows[r] = rows->Row(kI, y - radius + r) - radius;
    w_rows[r] = rows->Row(kW, y - radius + r) - radius;
  }
  const T* centre_mask = rows->Row(kMask, y);
  const T* centre_i = rows->Row(kI, y);
  const T* centre_w = rows->Row(kW, y);
  const size_t room = static_cast<size_t>(rows->columns) + lanes;
  for (auto& sums : rows->masked_sums) sums.resize(room);
  for (auto& centre : rows->masked_centre) centre.resize(room);
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1);
  for (; entry < row_end && columns[entry] < rows->x_begin + rows->columns - radius; ++entry) {
    const int x = columns[entry] - rows->x_begin;
    if (centre_mask[x] == T(0)) continue;
    const V ci = hn::Set(d, centre_i[x]);
    const V cw = hn::Set(d, centre_w[x]);
    V sums[6] = {zero, zero, zero, zero, zero, zero};
    for (int r = 0; r < side; ++r) {
      const uint32_t bits = RowBits(masks, entry, side, r);
      for (int k = 0; k < side; k += lanes) {
        if (bits >> k == 0) break;
        const auto tap =
            hn::And(LanesOf(d, bits >> k), hn::Gt(hn::LoadU(d, mask_rows[r] + x + k), zero));
        const V i = hn::IfThenElseZero(tap, hn::Sub(hn::LoadU(d, i_rows[r] + x + k), ci));
        const V w = hn::IfThenElseZero(tap, hn::Sub(hn::LoadU(d, w_rows[r] + x + k), cw));
        sums[0] = hn::Add(sums[0], hn::IfThenElseZero(tap, one));
        sums[1] = hn::Add(sums[1], i);
        sums[2] = hn::Add(sums[2], w);
        sums[3] = hn::MulAdd(i, i, sums[3]);
        sums[4] = hn::MulAdd(w, w, sums[4]);
        sums[5] = hn::MulAdd(i, w, sums[5]);
      }
    }
    const size_t n = rows->masked_column.size();
    for (int k = 0; k < 6; ++k) rows->masked_sums[k][n] = hn::GetLane(hn::SumOfLanes(d, sums[k]));
    rows->masked_centre[0][n] = centre_i[x];
    rows->masked_centre[1][n] = centre_w[x];
    rows->masked_column.push_back(x);
    rows->masked_entry.push_back(entry);
  }
}

// Adds a window's A, B, E, C and share to the kDirect rows of its taps.
template <typename T>
HWY_ATTR void SpreadWindow(const WindowMasks& masks, size_t entry, int x, int side,
                           const T values[], const T* const mask_rows[], T* const direct_rows[]) {
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kFields = KernelRows<T>::kTapFields;
  const V v[kFields] = {hn::Set(d, values[0]), hn::Set(d, values[1]), hn::Set(d, values[2]),
                        hn::Set(d, values[3]), hn::Set(d, values[4])};
  for (int r = 0; r < side; ++r) {
    const uint32_t bits = RowBits(masks, entry, side, r);
    for (int k = 0; k < side; k += lanes) {
      if (bits >> k == 0) break;
      const auto tap =
          hn::And(LanesOf(d, bits >> k), hn::Gt(hn::LoadU(d, mask_rows[r] + x + k), hn::Zero(d)));
      for (int field = 0; field < kFields; ++field) {
        T* at = direct_rows[kFields * r + field] + x + k;
        hn::StoreU(hn::Add(hn::LoadU(d, at), hn::IfThenElseZero(tap, v[field])), d, at);
      }
    }
  }
}

// Replaces what ScoreRow made of the windows of row y that have a mask and, with `derivatives`, adds
// their A, B, E, C and share to the kDirect rows of their taps instead of leaving them to the sums
// over windows.
template <typename T>
HWY_ATTR void ScoreMaskedWindows(const PairInput<T>& input, int y, bool derivatives,
                                 KernelRows<T>* rows) {
  SumMaskedWindows(input, y, rows);
  const size_t count = rows->masked_column.size();
  if (count == 0) return;
  const KernelTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const size_t lanes = hn::Lanes(d);
  const V floor = hn::Set(d, static_cast<T>(input.variance_floor));
  const V noise = hn::Set(d, static_cast<T>(input.reliability_noise));
  const V min_taps = hn::Set(d, static_cast<T>(input.min_taps));
  T* sums[7];
  for (int k = 0; k < 7; ++k) sums[k] = rows->masked_sums[k].data();
  for (size_t n = count; n < count + lanes; ++n) sums[0][n] = 0;
  for (size_t n = 0; n < count; n += lanes) {
    const V taps = hn::LoadU(d, sums[0] + n);
    WindowScores<V> score = ScoreWindows(d, hn::Ge(taps, min_taps), taps, hn::LoadU(d, sums[1] + n),
                                         hn::LoadU(d, sums[2] + n), hn::LoadU(d, sums[3] + n),
                                         hn::LoadU(d, sums[4] + n), hn::LoadU(d, sums[5] + n),
                                         floor, noise, input.reliability_noise > 0);
    const V centre_i = hn::LoadU(d, rows->masked_centre[0].data() + n);
    const V centre_w = hn::LoadU(d, rows->masked_centre[1].data() + n);
    score.e = hn::Add(score.e, hn::NegMulAdd(score.b, centre_w, hn::Mul(score.a, centre_i)));
    hn::StoreU(score.omega, d, sums[0] + n);
    hn::StoreU(score.cost, d, sums[1] + n);
    hn::StoreU(score.a, d, sums[2] + n);
    hn::StoreU(score.b, d, sums[3] + n);
    hn::StoreU(score.e, d, sums[4] + n);
    hn::StoreU(score.c, d, sums[5] + n);
    hn::StoreU(score.share, d, sums[6] + n);
  }
  const int radius = input.radius;
  const int side = 2 * radius + 1;
  const T* mask_rows[31];
  constexpr int kFields = KernelRows<T>::kTapFields;
  T* direct_rows[kFields * 31];
  for (int r = 0; r < side; ++r) {
    mask_rows[r] = rows->Row(kMask, y - radius + r) - radius;
    for (int field = 0; field < kFields; ++field) {
      direct_rows[kFields * r + field] = rows->Row(kDirectA + field, y - radius + r) - radius;
    }
    if (derivatives) rows->Direct(y - radius + r) = 1;
  }
  T* window[6];
  for (int k = 0; k < 6; ++k) window[k] = rows->Scratch(k);
  T* cost = rows->Row(kCost, y);
  for (size_t n = 0; n < count; ++n) {
    const size_t entry = rows->masked_entry[n];
    const int x = rows->masked_column[n];
    const bool valid = sums[0][n] > T(0);
    const bool in_full = input.full_below || (input.full_thin && input.masks->thin[entry] != 0);
    if (!valid && in_full) continue;  // as ScoreRow left it
    window[0][x] = sums[0][n];
    cost[x] = sums[1][n];
    for (int k = 1; k < 6; ++k) window[k][x] = T(0);
    if (!valid || !derivatives) continue;
    const T values[kFields] = {sums[2][n], sums[3][n], sums[4][n], sums[5][n], sums[6][n]};
    SpreadWindow<T>(*input.masks, entry, x, side, values, mask_rows, direct_rows);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
