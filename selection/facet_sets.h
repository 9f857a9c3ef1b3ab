// Which facets each view sees: one bit per view and facet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace burin {

class FacetSets {
 public:
  FacetSets() = default;
  FacetSets(int view_count, int facet_count)
      : facet_count_(facet_count),
        words_((static_cast<size_t>(facet_count) + 63) / 64),
        bits_(words_ * view_count, 0) {}

  int facet_count() const { return facet_count_; }

  // Calls for different views may run at the same time.
  void Insert(int view, int facet) { Row(view)[facet / 64] |= uint64_t{1} << (facet % 64); }
  bool Contains(int view, int facet) const { return (Row(view)[facet / 64] >> (facet % 64)) & 1U; }

  // Number of facets that both views see.
  int64_t CountShared(int i, int j) const {
    int64_t count = 0;
    for (size_t w = 0; w < words_; ++w) count += __builtin_popcountll(Row(i)[w] & Row(j)[w]);
    return count;
  }

  // Calls body(facet) for every facet that both views see, ascending.
  template <typename Body>
  void ForEachShared(int i, int j, Body body) const {
    for (size_t w = 0; w < words_; ++w) {
      for (uint64_t word = Row(i)[w] & Row(j)[w]; word != 0; word &= word - 1) {
        body(static_cast<int>(64 * w) + __builtin_ctzll(word));
      }
    }
  }

 private:
  uint64_t* Row(int view) { return bits_.data() + words_ * view; }
  const uint64_t* Row(int view) const { return bits_.data() + words_ * view; }

  int facet_count_ = 0;
  size_t words_ = 0;  // a view
  std::vector<uint64_t> bits_;
};

}  // namespace burin
