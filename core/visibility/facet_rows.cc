// Compiled for every target of the SIMD library (Highway) and dispatched at run time.
#include "core/visibility/facet_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/visibility/facet_rows.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace burin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kWideFacet = 16;       // columns from which on a row's ends are worth computing
constexpr double kRowEndsPx = 1e-3;  // what they may be off by

// Narrows [first, end) to columns that no edge rules out; `at` is what the edges are at x = 0.
HWY_ATTR inline void RowEnds(const FacetRows& facet, const double* at, int* first, int* end) {
  double low = *first;
  double high = *end;
  for (int k = 0; k < 3; ++k) {
    const double slope = facet.edge_x[k];
    if (slope == 0) {
      if (at[k] < 0) high = low;
      continue;
    }
    const double zero = -at[k] / slope - 0.5;
    if (slope > 0) {
      low = std::max(low, std::floor(zero - kRowEndsPx));
    } else {
      high = std::min(high, std::ceil(zero + kRowEndsPx) + 1);
    }
  }
  const bool any = high > low;
  *end = any ? static_cast<int>(high) : *first;
  *first = any ? static_cast<int>(low) : *first;
}

HWY_ATTR void DrawFacetRows(const FacetRows& facet, int64_t* rows, size_t stride) {
  const hn::CappedTag<double, kRowPadding> d;
  const hn::Rebind<float, decltype(d)> df;
  const hn::Rebind<int32_t, decltype(d)> d32;
  const hn::Rebind<int64_t, decltype(d)> d64;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto slope0 = hn::Set(d, facet.edge_x[0]);
  const auto slope1 = hn::Set(d, facet.edge_x[1]);
  const auto slope2 = hn::Set(d, facet.edge_x[2]);
  const auto least0 = hn::Set(d, facet.least[0]);
  const auto least1 = hn::Set(d, facet.least[1]);
  const auto least2 = hn::Set(d, facet.least[2]);
  const auto too_near = hn::Set(d, facet.too_near);
  const auto code0 = hn::Set(d64, static_cast<int64_t>(static_cast<uint32_t>(~facet.code)));
  const auto code1 = hn::Set(d64, static_cast<int64_t>(static_cast<uint32_t>(~(facet.code + 1))));
  const auto code2 = hn::Set(d64, static_cast<int64_t>(static_cast<uint32_t>(~(facet.code + 2))));
  const auto centre = hn::Iota(d, 0.5);
  for (int row = facet.first_row; row < facet.end_row; ++row) {
    const double y = row + 0.5;
    double at[3];
    for (int k = 0; k < 3; ++k) at[k] = facet.edge_y[k] * y + facet.edge_1[k];
    int first = facet.first_column;
    int end = facet.end_column;
    if (end - first > kWideFacet) RowEnds(facet, at, &first, &end);
    const auto depth_at = hn::Set(d, facet.depth[1] * y + facet.depth[2]);
    int64_t* HWY_RESTRICT to = rows + static_cast<size_t>(row) * stride;
    for (int column = first; column < end; column += lanes) {
      const auto x = hn::Add(hn::Set(d, static_cast<double>(column)), centre);
      const auto u0 = hn::MulAdd(slope0, x, hn::Set(d, at[0]));
      const auto u1 = hn::MulAdd(slope1, x, hn::Set(d, at[1]));
      const auto u2 = hn::MulAdd(slope2, x, hn::Set(d, at[2]));
      const auto inverse = hn::MulAdd(hn::Set(d, facet.depth[0]), x, depth_at);
      const auto on = hn::And(hn::And(hn::Ge(u0, least0), hn::Ge(u1, least1)),
                              hn::And(hn::Ge(u2, least2), hn::And(hn::Gt(inverse, hn::Zero(d)),
                                                                  hn::Lt(inverse, too_near))));
      const auto nearest2 = hn::RebindMask(d64, hn::Gt(u2, hn::Max(u0, u1)));
      const auto nearest1 = hn::RebindMask(d64, hn::Gt(u1, u0));
      const auto code = hn::IfThenElse(nearest2, code2, hn::IfThenElse(nearest1, code1, code0));
      const auto bits = hn::PromoteTo(d64, hn::BitCast(d32, hn::DemoteTo(df, inverse)));
      const auto drawn =
          hn::IfThenElseZero(hn::RebindMask(d64, on), hn::Or(hn::ShiftLeft<32>(bits), code));
      const auto before = hn::LoadU(d64, to + column);
      hn::StoreU(hn::IfThenElse(hn::Gt(drawn, before), drawn, before), d64, to + column);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace burin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace burin {

HWY_EXPORT(DrawFacetRows);

void DrawFacetRows(const FacetRows& facet, int64_t* rows, size_t stride) {
  HWY_DYNAMIC_DISPATCH(DrawFacetRows)(facet, rows, stride);
}

}  // namespace burin
#endif  // HWY_ONCE
