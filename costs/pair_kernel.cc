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
  // The same four, already added up per tap, of the windows that have a mask.
  kDirectA,
  kDirectB,
  kDirectE,
  kDirectC,
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

// Sums over the taps of a window, and what follows from them.
template <typename T>
struct WindowScore {
  T omega;  // 0 for a window that does not count
  T cost;   // omega (1 - z)
  T a;      // omega / (s_a s_b)
  T b;      // omega z / s_b^2
  T e;      // a mean_I - b mean_W
  T c;      // omega / s_b^2
};

template <typename T>
inline WindowScore<T> ScoreWindow(bool valid, T taps, T sum_i, T sum_w, T sum_ii, T sum_ww,
                                  T sum_iw, T floor, T noise) {
  const T n = valid ? taps : T(1);
  const T inverse_n = T(1) / n;
  const T mean_i = sum_i * inverse_n;
  const T mean_w = sum_w * inverse_n;
  const T variance_i = std::max(T(0), sum_ii - sum_i * mean_i);
  const T variance_w = std::max(T(0), sum_ww - sum_w * mean_w);
  const T covariance = sum_iw - sum_i * mean_w;
  const T square_a = variance_i + n * floor;
  const T square_b = variance_w + n * floor;
  const T omega = valid ? square_a / (square_a + n * noise) : T(0);
  const T inverse_ab = T(1) / std::sqrt(square_a * square_b);
  const T inverse_bb = T(1) / square_b;
  const T z = covariance * inverse_ab;
  const T weight_a = omega * inverse_ab;
  const T weight_b = omega * z * inverse_bb;
  return {omega,
          omega * (T(1) - z),
          weight_a,
          weight_b,
          weight_a * mean_i - weight_b * mean_w,
          omega * inverse_bb};
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
  if (input.masks != nullptr) {
    for (int field = kDirectA; field <= kDirectC; ++field) {
      std::fill(Row(field, y), Row(field, y) + columns_, T(0));
    }
  }
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
void PairKernel<T>::ScoreMaskedWindows(const PairInput<T>& input, int y, bool derivatives,
                                       T* const window[6]) {
  const WindowMasks& masks = *input.masks;
  if (y < 0 || y >= input.height) return;
  const int radius = input.radius;
  const int side = 2 * radius + 1;
  const int* columns = masks.column.data();
  const size_t row_end = masks.row_start[y + 1];
  size_t entry = static_cast<size_t>(
      std::lower_bound(columns + masks.row_start[y], columns + row_end, x_begin_ + radius) -
      columns);
  // The rows of the window, and where its taps are in them.
  enum { kRowMask, kRowI, kRowW, kRowA, kRowB, kRowE, kRowC, kRowCount };
  constexpr Field kFields[kRowCount] = {kMask, kI, kW, kDirectA, kDirectB, kDirectE, kDirectC};
  rows_of_window_.resize(static_cast<size_t>(kRowCount) * side);
  for (int k = 0; k < kRowCount; ++k) {
    for (int r = 0; r < side; ++r) {
      rows_of_window_[k * side + r] = Row(kFields[k], y - radius + r);
    }
  }
  const auto row = [this, side](int k, int r) { return rows_of_window_[k * side + r]; };
  taps_.resize(static_cast<size_t>(side) * side);
  offsets_.resize(taps_.size());
  for (int k = 0; k < side * side; ++k) offsets_[k] = {k % side - radius, k / side};
  const T* mask_row = row(kRowMask, radius);
  const T floor = static_cast<T>(input.variance_floor);
  const T noise = static_cast<T>(input.reliability_noise);
  for (; entry < row_end && columns[entry] < x_begin_ + columns_ - radius; ++entry) {
    const int x = columns[entry] - x_begin_;
    if (mask_row[x] == T(0)) continue;
    // Sums about the centre's values lose fewer digits.
    const T centre_i = row(kRowI, radius)[x];
    const T centre_w = row(kRowW, radius)[x];
    int taps = 0;
    T sums[5] = {0, 0, 0, 0, 0};
    for (int word = 0; word < masks.words; ++word) {
      for (uint64_t bits = masks.bits[entry * masks.words + word]; bits != 0; bits &= bits - 1) {
        const auto [dx, r] = offsets_[64 * word + __builtin_ctzll(bits)];
        if (row(kRowMask, r)[x + dx] == T(0)) continue;
        taps_[taps++] = {x + dx, r};
        const T i = row(kRowI, r)[x + dx] - centre_i;
        const T w = row(kRowW, r)[x + dx] - centre_w;
        sums[0] += i;
        sums[1] += w;
        sums[2] += i * i;
        sums[3] += w * w;
        sums[4] += i * w;
      }
    }
    const bool valid = taps >= input.min_taps;
    const bool in_full = input.full_below || (input.full_thin && masks.thin[entry] != 0);
    if (!valid && in_full) continue;  // as ScoreRow left it
    for (int k = 0; k < 6; ++k) window[k][x] = T(0);
    if (!valid) continue;
    WindowScore<T> score = ScoreWindow(true, static_cast<T>(taps), sums[0], sums[1], sums[2],
                                       sums[3], sums[4], floor, noise);
    score.e += score.a * centre_i - score.b * centre_w;
    window[0][x] = score.omega;
    window[1][x] = score.cost;
    if (!derivatives) continue;
    for (int t = 0; t < taps; ++t) {
      const auto [tap_x, r] = taps_[t];
      row(kRowA, r)[tap_x] += score.a;
      row(kRowB, r)[tap_x] += score.b;
      row(kRowE, r)[tap_x] += score.e;
      row(kRowC, r)[tap_x] += score.c;
    }
  }
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
  // Overwrites the sums: count -> omega, sum_i -> cost, and A, B, E, C in the order of the fields.
  for (int x = begin; x < end; ++x) {
    const bool valid = mask[x] != T(0) && count[x] >= min_taps;
    const WindowScore<T> score = ScoreWindow(valid, count[x], sum_i[x], sum_w[x], sum_ii[x],
                                             sum_ww[x], sum_iw[x], floor, noise);
    count[x] = score.omega;
    sum_i[x] = score.cost;
    sum_w[x] = score.a;
    sum_ii[x] = score.b;
    sum_ww[x] = score.e;
    sum_iw[x] = score.c;
  }
  if (input.masks != nullptr) ScoreMaskedWindows(input, y, derivatives, window);
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
    if (input.masks != nullptr) AddRow(Row(kDirectA + k, y), begin, end, sums[k]);
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
