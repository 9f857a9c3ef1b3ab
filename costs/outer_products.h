// Sums of outer products of short vectors, vectorised.
#pragma once

namespace burin {

// Pairs of vectors of kSize numbers.
template <typename T>
struct VectorPairs {
  static constexpr int kSize = 16;
  static constexpr int kMost = 64;
  int count = 0;
  alignas(64) T left[kMost][kSize];
  alignas(64) T right[kMost][kSize];
};

// sums[k][l] += sum_n left[n][k] right[n][l] over all pairs; `sums` is aligned as these are.
void AddOuterProducts(const VectorPairs<float>& pairs, float (*sums)[16]);
void AddOuterProducts(const VectorPairs<double>& pairs, double (*sums)[16]);

}  // namespace burin
