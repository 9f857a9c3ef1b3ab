// Windows that lost taps to an occlusion mask (see costs/pair_kernel.h): a vector of neighbouring windows at
// a time, tap by tap, each window with the taps that its mask has. Blocks of columns without such windows
// are passed over. Included once per target of the SIMD library.
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

// Row r of a window's mask: bit k = tap k from the left.
inline uint32_t RowBits(const uint64_t* words, int side, int r) {
  const int begin = side * r;
  const int shift = begin % 64;
  uint64_t bits = words[begin / 64] >> shift;
  if (shift + side > 64) bits |= words[begin / 64 + 1] << (64 - shift);
  return static_cast<uint32_t>(bits & ((uint64_t{1} << side) - 1));
}

// Windows that have tap k from the left of window row r, 0 at the top; `taps` as KernelRows has them.
template <int kRadius, class D, typename Bits>
HWY_INLINE hn::Mask<D> HaveTap(D d, const Bits* taps, int radius, int r, int k) {
  const hn::RebindToSigned<D> di;
  auto bits = hn::LoadU(di, taps);
  const bool one_word = kRadius > 0 && kRadius <= KernelRows<hn::TFromD<D>>::kOneWord;
  if (one_word) bits = hn::ShiftRightSame(bits, r * (2 * radius + 1));
  return hn::RebindMask(d, hn::TestBit(bits, hn::Set(di, Bits{1} << k)));
}

// The window row's word.
template <int kRadius, typename T>
const typename KernelRows<T>::Bits* TapWord(int r, int y, KernelRows<T>* rows) {
  const bool one_word = kRadius > 0 && kRadius <= KernelRows<T>::kOneWord;
  return rows->Taps(one_word ? 0 : r, y);
}

// Puts the masks of row y's windows that lie in Omega_ij where the vectors find them.
template <typename T>
void PlaceMasks(const PairInput<T>& input, int y, KernelRows<T>* rows) {
  using Rows = KernelRows<T>;
  using Bits = typename Rows::Bits;
  if (y < 0 || y >= input.height) return;
  const WindowMasks& masks = *input.masks;
  const int radius = rows->radius;
  const int side = 2 * radius + 1;
  const int* columns = masks.column.data();
  const size_t row_end = masks.row_start[y + 1];
  size_t entry = static_cast<size_t>(
      std::lower_bound(columns + masks.row_start[y], columns + row_end, rows->x_begin + radius) -
      columns);
  const T* in_domain = rows->Row(kMask, y);
  char* HWY_RESTRICT blocks = rows->MaskedBlocks(y);
  char* HWY_RESTRICT reached = rows->ReachedBlocks(y);
  bool any = false;
  Bits* state = rows->Masked(y);
  Bits* first_word = rows->Taps(0, y);
  const bool one_word = rows->words == 1;
  const int end = rows->x_begin + rows->columns - radius;
  for (; entry < row_end && columns[entry] < end; ++entry) {
    const int x = columns[entry] - rows->x_begin;
    if (in_domain[x] == T(0)) continue;
    const uint64_t* bits = masks.bits.data() + entry * masks.words;
    if (one_word) {
      first_word[x] = static_cast<Bits>(bits[0]);
    } else {
      for (int r = 0; r < side; ++r)
        rows->Taps(r, y)[x] = static_cast<Bits>(RowBits(bits, side, r));
    }
    const bool full = input.full_below || (input.full_thin && masks.thin[entry] != 0);
    state[x] = full ? Rows::kWindowMasked | Rows::kWindowFull : Rows::kWindowMasked;
    blocks[x / Rows::kBlock] = 1;
    reached[(x - radius) / Rows::kBlock] = 1;
    reached[(x + radius) / Rows::kBlock] = 1;
    any = true;
  }
  rows->HasMasked(y) = any ? 1 : 0;
}

// Scores the windows of row y at the lanes from x; `taken` are those that have a mask and taps in it.
// The sums are about the values of the centre, which loses fewer digits.
template <int kRadius, class D, typename T = hn::TFromD<D>>
HWY_INLINE WindowScores<hn::Vec<D>> ScoreMasked(D d, const PairInput<T>& input, int y, int x,
                                                hn::Mask<D> masked, KernelRows<T>* rows,
                                                hn::Mask<D>* taken) {
  using V = hn::Vec<D>;
  const V one = hn::Set(d, 1);
  const V zero = hn::Zero(d);
  const V centre_i = hn::Load(d, rows->Row(kI, y) + x);
  const V centre_w = hn::Load(d, rows->Row(kW, y) + x);
  V taps = zero;
  V sum_i = zero;
  V sum_w = zero;
  V sum_ii = zero;
  V sum_ww = zero;
  V sum_iw = zero;
  const int radius = Radius<kRadius>(*rows);
  for (int r = 0; r <= 2 * radius; ++r) {
    const T* HWY_RESTRICT in_domain = rows->Row(kMask, y + r - radius) + x - radius;
    const T* HWY_RESTRICT intensity = rows->Row(kI, y + r - radius) + x - radius;
    const T* HWY_RESTRICT warped = rows->Row(kW, y + r - radius) + x - radius;
    const auto* word = TapWord<kRadius>(r, y, rows) + x;
    for (int k = 0; k <= 2 * radius; ++k) {
      const auto kept = hn::And(HaveTap<kRadius>(d, word, radius, r, k),
                                hn::Gt(hn::LoadU(d, in_domain + k), zero));
      const V i = hn::IfThenElseZero(kept, hn::Sub(hn::LoadU(d, intensity + k), centre_i));
      const V w = hn::IfThenElseZero(kept, hn::Sub(hn::LoadU(d, warped + k), centre_w));
      taps = hn::Add(taps, hn::IfThenElseZero(kept, one));
      sum_i = hn::Add(sum_i, i);
      sum_w = hn::Add(sum_w, w);
      sum_ii = hn::MulAdd(i, i, sum_ii);
      sum_ww = hn::MulAdd(w, w, sum_ww);
      sum_iw = hn::MulAdd(i, w, sum_iw);
    }
  }
  *taken = hn::And(masked, hn::Ge(taps, hn::Set(d, static_cast<T>(input.min_taps))));
  WindowScores<V> score = ScoreWindows(d, *taken, taps, sum_i, sum_w, sum_ii, sum_ww, sum_iw,
                                       hn::Set(d, static_cast<T>(input.variance_floor)),
                                       hn::Set(d, static_cast<T>(input.reliability_noise)),
                                       input.reliability_noise > 0);
  score.e = hn::Add(score.e, hn::NegMulAdd(score.b, centre_w, hn::Mul(score.a, centre_i)));
  return score;
}

// Replaces what ScoreRow made of the windows of row y that have a mask: omega and cost in their rows; A,
// B, E, C and share in the kMasked rows instead of the rows that are summed over windows.
template <int kRadius, typename T>
HWY_ATTR void ScoreMaskedWindows(const PairInput<T>& input, int y, KernelRows<T>* rows) {
  using Rows = KernelRows<T>;
  const KernelTag<T> d;
  const hn::RebindToSigned<decltype(d)> di;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  PlaceMasks(input, y, rows);
  if (rows->HasMasked(y) == 0) return;
  const auto masked_bit = hn::Set(di, Rows::kWindowMasked);
  const auto full_bit = hn::Set(di, Rows::kWindowFull);
  const V zero = hn::Zero(d);
  const char* blocks = rows->MaskedBlocks(y);
  for (int x = 0; x < rows->columns; x += lanes) {
    if (blocks[x / Rows::kBlock] == 0) continue;
    const auto state = hn::Load(di, rows->Masked(y) + x);
    const auto masked = hn::RebindMask(d, hn::TestBit(state, masked_bit));
    if (hn::AllFalse(d, masked)) continue;
    auto taken = masked;
    const WindowScores<V> score = ScoreMasked<kRadius>(d, input, y, x, masked, rows, &taken);
    // Not those that ScoreRow was right to leave full.
    const auto replaced =
        hn::Or(taken, hn::AndNot(hn::RebindMask(d, hn::TestBit(state, full_bit)), masked));
    T* omega = rows->Scratch(0) + x;
    T* cost = rows->Row(kCost, y) + x;
    hn::Store(hn::IfThenElse(replaced, score.omega, hn::Load(d, omega)), d, omega);
    hn::Store(hn::IfThenElse(replaced, score.cost, hn::Load(d, cost)), d, cost);
    const V values[Rows::kTapFields] = {score.a, score.b, score.e, score.c, score.share};
    for (int k = 0; k < Rows::kTapFields; ++k) {
      T* whole = rows->Scratch(1 + k) + x;
      hn::Store(hn::IfThenElse(replaced, zero, hn::Load(d, whole)), d, whole);
      hn::Store(hn::IfThenElseZero(taken, values[k]), d, rows->Row(kMaskedA + k, y) + x);
    }
  }
}

// The masked windows that have pixels of a row as taps.
template <int kRadius, typename T>
class MaskedAround {
 public:
  MaskedAround(int y, KernelRows<T>* rows) : radius_(Radius<kRadius>(*rows)) {
    for (int r = -radius_; r <= radius_; ++r) {
      if (rows->HasMasked(y + r) == 0) continue;
      Row& row = rows_[count_++];
      row.tap_row = radius_ - r;
      row.word = TapWord<kRadius>(row.tap_row, y + r, rows);
      row.reached = rows->ReachedBlocks(y + r);
      for (int f = 0; f < kFields; ++f) row.fields[f] = rows->Row(kMaskedA + f, y + r);
    }
  }

  // Adds their A, B, E, C and share to the pixels at the lanes from x. What is added outside Omega_ij does
  // not count.
  template <class D, class V = hn::Vec<D>>
  HWY_INLINE void Add(D d, int x, V* a, V* b, V* e, V* c, V* share) const {
    for (int n = 0; n < count_; ++n) {
      const Row& row = rows_[n];
      if (row.reached[x / kBlock] == 0) continue;
      for (int k = 0; k <= 2 * radius_; ++k) {
        const int at = x + radius_ - k;  // tap k of the window there is at x
        const auto kept = HaveTap<kRadius>(d, row.word + at, radius_, row.tap_row, k);
        V* const sums[kFields] = {a, b, e, c, share};
        for (int f = 0; f < kFields; ++f) {
          *sums[f] = hn::Add(*sums[f], hn::IfThenElseZero(kept, hn::LoadU(d, row.fields[f] + at)));
        }
      }
    }
  }

 private:
  static constexpr int kBlock = KernelRows<T>::kBlock;
  static constexpr int kFields = KernelRows<T>::kTapFields;
  struct Row {
    int tap_row;  // of the windows there
    const typename KernelRows<T>::Bits* word;
    const char* reached;
    const T* fields[kFields];
  };
  int radius_;
  int count_ = 0;
  Row rows_[31];
};

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#endif  // target toggle
