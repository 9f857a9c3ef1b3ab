#include "costs/outer_products.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "costs/outer_products.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Four rows of the sums at a time, enough to hide most of the latency of a sum.
template <typename T>
HWY_ATTR void AddAll(const VectorPairs<T>& pairs, T (*sums)[16]) {
  constexpr int kSize = VectorPairs<T>::kSize;
  const hn::CappedTag<T, kSize> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int k = 0; k < kSize; k += 4) {
    for (int l = 0; l < kSize; l += lanes) {
      auto sum_0 = hn::Load(d, sums[k] + l);
      auto sum_1 = hn::Load(d, sums[k + 1] + l);
      auto sum_2 = hn::Load(d, sums[k + 2] + l);
      auto sum_3 = hn::Load(d, sums[k + 3] + l);
      for (int n = 0; n < pairs.count; ++n) {
        const T* left = pairs.left[n] + k;
        const auto right = hn::Load(d, pairs.right[n] + l);
        sum_0 = hn::MulAdd(hn::Set(d, left[0]), right, sum_0);
        sum_1 = hn::MulAdd(hn::Set(d, left[1]), right, sum_1);
        sum_2 = hn::MulAdd(hn::Set(d, left[2]), right, sum_2);
        sum_3 = hn::MulAdd(hn::Set(d, left[3]), right, sum_3);
      }
      hn::Store(sum_0, d, sums[k] + l);
      hn::Store(sum_1, d, sums[k + 1] + l);
      hn::Store(sum_2, d, sums[k + 2] + l);
      hn::Store(sum_3, d, sums[k + 3] + l);
    }
  }
}

// What the dispatch tables point to: no templates there.
void AddAllFloat(const VectorPairs<float>& pairs, float (*sums)[16]) { AddAll(pairs, sums); }
void AddAllDouble(const VectorPairs<double>& pairs, double (*sums)[16]) { AddAll(pairs, sums); }

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace burin {

HWY_EXPORT(AddAllFloat);
HWY_EXPORT(AddAllDouble);

void AddOuterProducts(const VectorPairs<float>& pairs, float (*sums)[16]) {
  HWY_DYNAMIC_DISPATCH(AddAllFloat)(pairs, sums);
}
void AddOuterProducts(const VectorPairs<double>& pairs, double (*sums)[16]) {
  HWY_DYNAMIC_DISPATCH(AddAllDouble)(pairs, sums);
}

}  // namespace burin
#endif  // HWY_ONCE
