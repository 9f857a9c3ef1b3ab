// What an evaluation leaves of every corner of every facet: sums over its pixels in all views, by which
// costs/photometric_round.h has energy, gradient and curvature. A pixel belongs to the corner with its largest
// barycentric coordinate.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace burin {

struct CornerSums {
  double cost = 0;  // of the windows centred there
  // Of the cost of all windows that have a tap there: a window gives each tap cost / n.
  double share = 0;
  double slope[3] = {0, 0, 0};
  double curvature[6] = {0, 0, 0, 0, 0, 0};  // (0,0) (0,1) (0,2) (1,1) (1,2) (2,2)

  // Where (k, l) and (l, k) are in `curvature`.
  static constexpr int Packed(int k, int l) {
    constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    return kPacked[k][l];
  }
};

// Those of all facets, in the precision of the fields that they are made from. Threads may add at the same time, each
// to corners of its own.
class CornerSumsList {
 public:
  static size_t BytesPerCorner(bool in_double) {
    return kNumbers * (in_double ? sizeof(double) : sizeof(float));
  }

  // Keeps what is there, which is anything where the list grows.
  void Resize(size_t corners, bool in_double) {
    in_double_ = in_double;
    size_ = corners;
    doubles_.resize(in_double ? corners * kNumbers : 0);
    floats_.resize(in_double ? 0 : corners * kNumbers);
  }
  size_t size() const { return size_; }
  void Clear(size_t begin, size_t end) {
    if (in_double_) {
      std::fill(doubles_.begin() + At(begin), doubles_.begin() + At(end), 0.0);
    } else {
      std::fill(floats_.begin() + At(begin), floats_.begin() + At(end), 0.0F);
    }
  }

  CornerSums operator[](size_t corner) const {
    return in_double_ ? Read(&doubles_[kNumbers * corner]) : Read(&floats_[kNumbers * corner]);
  }
  double Cost(size_t corner) const {
    return in_double_ ? doubles_[kNumbers * corner] : floats_[kNumbers * corner];
  }
  void Add(size_t corner, const CornerSums& sums) {
    if (in_double_) {
      AddTo(&doubles_[kNumbers * corner], sums);
    } else {
      AddTo(&floats_[kNumbers * corner], sums);
    }
  }
  void Prefetch(size_t corner) const {
    const void* at = in_double_ ? static_cast<const void*>(&doubles_[kNumbers * corner])
                                : static_cast<const void*>(&floats_[kNumbers * corner]);
    __builtin_prefetch(at, 1);
  }

 private:
  static constexpr size_t kNumbers = 11;

  static ptrdiff_t At(size_t corner) { return static_cast<ptrdiff_t>(kNumbers * corner); }
  template <typename T>
  static CornerSums Read(const T* from) {
    CornerSums sums;
    sums.cost = from[0];
    sums.share = from[1];
    for (int k = 0; k < 3; ++k) sums.slope[k] = from[2 + k];
    for (int k = 0; k < 6; ++k) sums.curvature[k] = from[5 + k];
    return sums;
  }
  template <typename T>
  static void AddTo(T* to, const CornerSums& sums) {
    to[0] += static_cast<T>(sums.cost);
    to[1] += static_cast<T>(sums.share);
    for (int k = 0; k < 3; ++k) to[2 + k] += static_cast<T>(sums.slope[k]);
    for (int k = 0; k < 6; ++k) to[5 + k] += static_cast<T>(sums.curvature[k]);
  }

  bool in_double_ = false;
  size_t size_ = 0;
  std::vector<double> doubles_;
  std::vector<float> floats_;
};

}  // namespace burin
