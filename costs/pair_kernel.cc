#include "costs/pair_kernel.h"

#include <algorithm>
#include <cmath>

namespace burin {
namespace {

// Fields held as rows. Zero outside Omega_ij.
enum Field {
  kMask,  // 1 in Omega_ij
  kI,     // I
  kW,     // W
  kD,     // dW/ds
  // Horizontal sums over the taps of a window row.
  kSumMask,
  kSumI,
  kSumW,
  kSumII,
  kSumWW,
  kSumIW,
  // Horizontal sums over windows of what dE/dW needs.
  kSumA,  // A = omega / (s_a s_b)
  kSumB,  // B = omega z / s_b^2
  kSumE,  // A mean_I - B mean_W
  kSumC,  // omega / s_b^2
  kFieldCount
};
constexpr int kScratchRows = 6;

// out[x] = sum of in[x - radius .. x + radius] for x in [radius, columns - radius).
template <typename T>
void BoxRow(const T* __restrict in, int columns, int radius, T* __restrict out) {
  if (radius == 2) {
    for (int x = 2; x < columns - 2; ++x) {
      out[x] = ((in[x - 2] + in[x - 1]) + (in[x + 1] + in[x + 2])) + in[x];
    }
    return;
  }
  for (int x = radius; x < columns - radius; ++x) {
    T sum = 0;
    for (int k = -radius; k <= radius; ++k) sum += in[x + k];
    out[x] = sum;
  }
}

template <typename T>
void AddRow(const T* __restrict in, int begin, int end, T* __restrict out) {
  for (int x = begin; x < end; ++x) out[x] += in[x];
}

}  // namespace

template <typename T>
void PixelFields<T>::Reset(size_t size, bool derivatives) {
  cost.assign(size, T(0));
  slope.assign(derivatives ? size : 0, T(0));
  curvature.assign(derivatives ? size : 0, T(0));
}

template <typename T>
void PairKernel<T>::WarpRow(const PairInput<T>& input, int y, bool derivatives) {
  T* __restrict mask = Row(kMask, y);
  T* __restrict intensity = Row(kI, y);
  T* __restrict warped = Row(kW, y);
  T* __restrict slope = Row(kD, y);
  std::fill(mask, mask + columns_, T(0));
  std::fill(intensity, intensity + columns_, T(0));
  std::fill(warped, warped + columns_, T(0));
  std::fill(slope, slope + columns_, T(0));
  Used(y) = 0;
  if (y < 0 || y >= input.height) return;

  const int lead = std::max(0, -x_begin_);  // columns left of the image
  const int stop = std::min(columns_, input.width - x_begin_);
  const size_t first = static_cast<size_t>(y) * input.width + lead + x_begin_;
  const uint8_t* domain = input.domain + first - lead;
  unsigned int any = 0;
  for (int x = lead; x < stop; ++x) {
    const unsigned int in = domain[x] & input.bit;
    mask[x] = in != 0 ? T(1) : T(0);
    any |= in;
  }
  if (any == 0) return;
  Used(y) = 1;

  // Homogeneous warp, the row's start in double, increments in T.
  const double* a = input.warp;
  const double xc = x_begin_ + 0.5;
  const double yc = y + 0.5;
  const T bx = static_cast<T>(a[0] * xc + a[1] * yc + a[2]);
  const T by = static_cast<T>(a[3] * xc + a[4] * yc + a[5]);
  const T bz = static_cast<T>(a[6] * xc + a[7] * yc + a[8]);
  const T ix = static_cast<T>(a[0]);
  const T iy = static_cast<T>(a[3]);
  const T iz = static_cast<T>(a[6]);
  const T ex = static_cast<T>(input.epipole[0]);
  const T ey = static_cast<T>(input.epipole[1]);
  const T ez = static_cast<T>(input.epipole[2]);
  const T* __restrict depth = input.inverse_depth + first - lead;
  const float* __restrict source = input.image + first - lead;
  T* __restrict px = Scratch(0);
  T* __restrict py = Scratch(1);
  T* __restrict dx = Scratch(2);
  T* __restrict dy = Scratch(3);
  for (int x = lead; x < stop; ++x) {
    const T s = depth[x];
    const T column = static_cast<T>(x);
    const T inverse = T(1) / (bz + iz * column + ez * s);
    const T qx = (bx + ix * column + ex * s) * inverse;
    const T qy = (by + iy * column + ey * s) * inverse;
    px[x] = qx;
    py[x] = qy;
    dx[x] = (ex - qx * ez) * inverse;
    dy[x] = (ey - qy * ez) * inverse;
    intensity[x] = static_cast<T>(source[x] - input.grey_offset) * mask[x];
  }
  const SplineImage<T>& second = *input.second;
  if (derivatives) {
    for (int x = lead; x < stop; ++x) {
      if (mask[x] == T(0)) continue;
      T gx;
      T gy;
      second.Sample(px[x], py[x], &warped[x], &gx, &gy);
      slope[x] = gx * dx[x] + gy * dy[x];
    }
  } else {
    for (int x = lead; x < stop; ++x) {
      if (mask[x] != T(0)) second.Sample(px[x], py[x], &warped[x]);
    }
  }
}

template <typename T>
void PairKernel<T>::SumRow(int y) {
  const int radius = (ring_ - 1) / 2;
  if (Used(y) == 0) {
    for (int field = kSumMask; field <= kSumIW; ++field) {
      std::fill(Row(field, y), Row(field, y) + columns_, T(0));
    }
    return;
  }
  const T* __restrict intensity = Row(kI, y);
  const T* __restrict warped = Row(kW, y);
  T* __restrict ii = Scratch(0);
  T* __restrict ww = Scratch(1);
  T* __restrict iw = Scratch(2);
  for (int x = 0; x < columns_; ++x) {
    ii[x] = intensity[x] * intensity[x];
    ww[x] = warped[x] * warped[x];
    iw[x] = intensity[x] * warped[x];
  }
  BoxRow(Row(kMask, y), columns_, radius, Row(kSumMask, y));
  BoxRow(intensity, columns_, radius, Row(kSumI, y));
  BoxRow(warped, columns_, radius, Row(kSumW, y));
  BoxRow(ii, columns_, radius, Row(kSumII, y));
  BoxRow(ww, columns_, radius, Row(kSumWW, y));
  BoxRow(iw, columns_, radius, Row(kSumIW, y));
}

template <typename T>
int64_t PairKernel<T>::ScoreRow(const PairInput<T>& input, const Tile& tile, int y,
                                bool derivatives, PixelFields<T>* fields) {
  const int radius = input.radius;
  const int begin = radius;
  const int end = columns_ - radius;
  if (Used(y) == 0) {
    for (int field = kSumA; field <= kSumC; ++field) {
      std::fill(Row(field, y), Row(field, y) + columns_, T(0));
    }
    return 0;
  }
  // Window sums: the horizontal sums of the 2 radius + 1 rows around y.
  T* window[6];
  for (int k = 0; k < 6; ++k) {
    window[k] = Scratch(k);
    const T* top = Row(kSumMask + k, y - radius);
    std::copy(top + begin, top + end, window[k] + begin);
    for (int row = y - radius + 1; row <= y + radius; ++row) {
      if (Used(row) != 0) AddRow(Row(kSumMask + k, row), begin, end, window[k]);
    }
  }
  const T* __restrict mask = Row(kMask, y);
  T* __restrict count = window[0];
  T* __restrict sum_i = window[1];
  T* __restrict sum_w = window[2];
  T* __restrict sum_ii = window[3];
  T* __restrict sum_ww = window[4];
  T* __restrict sum_iw = window[5];
  const T floor = static_cast<T>(input.variance_floor);
  const T noise = static_cast<T>(input.reliability_noise);
  const T min_taps = static_cast<T>(input.min_taps);
  // Overwrites the sums: count -> omega, sum_i -> 1 - z, and A, B, E, C in the order of the fields.
  for (int x = begin; x < end; ++x) {
    const bool valid = mask[x] != T(0) && count[x] >= min_taps;
    const T n = valid ? count[x] : T(1);
    const T inverse_n = T(1) / n;
    const T mean_i = sum_i[x] * inverse_n;
    const T mean_w = sum_w[x] * inverse_n;
    const T variance_i = std::max(T(0), sum_ii[x] - sum_i[x] * mean_i);
    const T variance_w = std::max(T(0), sum_ww[x] - sum_w[x] * mean_w);
    const T covariance = sum_iw[x] - sum_i[x] * mean_w;
    const T square_a = variance_i + n * floor;
    const T square_b = variance_w + n * floor;
    const T omega = valid ? square_a / (square_a + n * noise) : T(0);
    const T inverse_ab = T(1) / std::sqrt(square_a * square_b);
    const T inverse_bb = T(1) / square_b;
    const T z = covariance * inverse_ab;
    const T weight_a = omega * inverse_ab;
    const T weight_b = omega * z * inverse_bb;
    count[x] = omega;
    sum_i[x] = omega * (T(1) - z);
    sum_w[x] = weight_a;
    sum_ii[x] = weight_b;
    sum_ww[x] = weight_a * mean_i - weight_b * mean_w;
    sum_iw[x] = omega * inverse_bb;
  }
  int64_t counted = 0;
  if (y >= tile.y0 && y < tile.y1) {
    T* __restrict cost = fields->cost.data() + static_cast<size_t>(y) * input.width + x_begin_;
    for (int x = tile.x0 - x_begin_; x < tile.x1 - x_begin_; ++x) {
      cost[x] += sum_i[x];
      counted += count[x] > T(0) ? 1 : 0;
    }
  }
  if (derivatives) {
    for (int k = 0; k < 4; ++k) {
      // Windows beyond the held columns are not needed by any tap of the tile.
      std::fill(window[2 + k], window[2 + k] + begin, T(0));
      std::fill(window[2 + k] + end, window[2 + k] + columns_, T(0));
      BoxRow(window[2 + k], columns_, radius, Row(kSumA + k, y));
    }
  }
  return counted;
}

template <typename T>
void PairKernel<T>::DifferentiateRow(const PairInput<T>& input, const Tile& tile, int y,
                                     PixelFields<T>* fields) {
  if (Used(y) == 0) return;
  const int radius = input.radius;
  const int begin = tile.x0 - x_begin_;
  const int end = tile.x1 - x_begin_;
  T* sums[4];
  for (int k = 0; k < 4; ++k) {
    sums[k] = Scratch(k);
    const T* top = Row(kSumA + k, y - radius);
    std::copy(top + begin, top + end, sums[k] + begin);
    for (int row = y - radius + 1; row <= y + radius; ++row) {
      AddRow(Row(kSumA + k, row), begin, end, sums[k]);
    }
  }
  const T* __restrict intensity = Row(kI, y);
  const T* __restrict warped = Row(kW, y);
  const T* __restrict d = Row(kD, y);
  const T* __restrict sum_a = sums[0];
  const T* __restrict sum_b = sums[1];
  const T* __restrict sum_e = sums[2];
  const T* __restrict sum_c = sums[3];
  const size_t first = static_cast<size_t>(y) * input.width + tile.x0 - begin;
  T* __restrict slope = fields->slope.data() + first;
  T* __restrict curvature = fields->curvature.data() + first;
  // d is zero outside Omega_ij, so that nothing is added there.
  for (int x = begin; x < end; ++x) {
    const T dE_dW = sum_e[x] + warped[x] * sum_b[x] - intensity[x] * sum_a[x];
    slope[x] += dE_dW * d[x];
    curvature[x] += sum_c[x] * d[x] * d[x];
  }
}

template <typename T>
int64_t PairKernel<T>::AddTile(const PairInput<T>& input, const Tile& tile, bool derivatives,
                               PixelFields<T>* fields) {
  const int radius = input.radius;
  const int halo = derivatives ? 2 * radius : radius;
  x_begin_ = tile.x0 - 2 * radius;
  y_begin_ = tile.y0 - 3 * radius;
  columns_ = tile.x1 - tile.x0 + 4 * radius;
  ring_ = 2 * radius + 1;
  stride_ = (columns_ + 15) / 16 * 16;
  rows_.resize(static_cast<size_t>(kFieldCount) * ring_ * stride_);
  scratch_.resize(kScratchRows * stride_);
  used_.assign(ring_, 0);
  std::fill(rows_.begin(), rows_.end(), T(0));

  int64_t counted = 0;
  for (int y = tile.y0 - halo; y < tile.y1 + halo; ++y) {
    WarpRow(input, y, derivatives);
    SumRow(y);
    const int scored = y - radius;
    if (scored < tile.y0 - (halo - radius) || scored >= tile.y1 + (halo - radius)) continue;
    counted += ScoreRow(input, tile, scored, derivatives, fields);
    const int done = scored - radius;
    if (derivatives && done >= tile.y0 && done < tile.y1) {
      DifferentiateRow(input, tile, done, fields);
    }
  }
  return counted;
}

template class PairKernel<float>;
template class PairKernel<double>;
template struct PixelFields<float>;
template struct PixelFields<double>;

}  // namespace burin
