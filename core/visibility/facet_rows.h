// Draws one facet into a depth buffer of whole rows, several pixels at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace burin {

// Pixels that a row of a depth buffer has beyond its image: what is drawn at once may end there.
constexpr int kRowPadding = 8;

// A pixel of a depth buffer: the bits of its inverse depth (float, not negative) above those of ~code, so that the
// larger number is the nearer surface and of equal depths the smaller code. 0 = nothing, whose code is -1.
inline int CodeOf(int64_t pixel) { return ~static_cast<int>(static_cast<uint32_t>(pixel)); }
inline float InverseDepthOf(int64_t pixel) {
  const auto bits = static_cast<uint32_t>(pixel >> 32);
  float inverse_depth;
  std::memcpy(&inverse_depth, &bits, sizeof(bits));
  return inverse_depth;
}

struct FacetRows {
  int first_column;
  int end_column;
  int first_row;
  int end_row;
  // |det| u_k (core/visibility/facet_map.h) is edge_x[k] x + edge_y[k] y + edge_1[k].
  double edge_x[3];
  double edge_y[3];
  double edge_1[3];
  double least[3];  // of it at pixels of the facet
  double depth[3];  // its inverse, in the same way
  double too_near;  // the least inverse depth that is not seen
  int code;         // of corner 0; those of corners 1 and 2 follow
};

// `rows` is the buffer's first row, each `stride` long: the image's width and kRowPadding.
void DrawFacetRows(const FacetRows& facet, int64_t* rows, size_t stride);

}  // namespace burin
