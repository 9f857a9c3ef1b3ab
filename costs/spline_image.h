// An image as a cubic B-spline: value and gradient at any point, twice continuously differentiable.
//
// The spline interpolates the samples (array element (row, col) at image point (col+0.5, row+0.5)),
// with mirrored borders; coefficients come from the recursive prefilter with pole sqrt(3) - 2
// (Unser, "Splines: a perfect fit for signal and image processing", 1999). Bilinear sampling would
// leave kinks in the energy on which line searches stall. Beyond kPadding - 2 pixels outside the
// image the point is clamped and Sample() reports gradient zero.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace burin {

template <typename T>
class SplineImage {
 public:
  static constexpr int kPadding = 8;

  SplineImage() = default;
  // `offset` is subtracted from every sample (a spline reproduces constants, so sampled values are
  // shifted by exactly that); it keeps single-precision window sums small.
  SplineImage(const cv::Mat1f& image, T offset);

  int width() const { return width_; }
  int height() const { return height_; }

  // Value at image point (x, y).
  void Sample(T x, T y, T* value) const {
    T tx;
    T ty;
    bool inside;
    const T* corner = Locate(x, y, &tx, &ty, &inside);
    const Vec4 weight_y = Weights(ty);
    const Vec4 rows = weight_y[0] * Load(corner) + weight_y[1] * Load(corner + stride_) +
                      weight_y[2] * Load(corner + 2 * stride_) +
                      weight_y[3] * Load(corner + 3 * stride_);
    *value = Sum(rows * Weights(tx));
  }

  // Value and gradient (per pixel) at image point (x, y).
  void Sample(T x, T y, T* value, T* gradient_x, T* gradient_y) const {
    T tx;
    T ty;
    bool inside;
    const T* corner = Locate(x, y, &tx, &ty, &inside);
    const Vec4 weight_x = Weights(tx);
    const Vec4 weight_y = Weights(ty);
    const Vec4 slope_y = Slopes(ty);
    const Vec4 row0 = Load(corner);
    const Vec4 row1 = Load(corner + stride_);
    const Vec4 row2 = Load(corner + 2 * stride_);
    const Vec4 row3 = Load(corner + 3 * stride_);
    const Vec4 rows =
        weight_y[0] * row0 + weight_y[1] * row1 + weight_y[2] * row2 + weight_y[3] * row3;
    const Vec4 row_slopes =
        slope_y[0] * row0 + slope_y[1] * row1 + slope_y[2] * row2 + slope_y[3] * row3;
    *value = Sum(rows * weight_x);
    *gradient_x = inside ? Sum(rows * Slopes(tx)) : T(0);
    *gradient_y = inside ? Sum(row_slopes * weight_x) : T(0);
  }

 private:
  using Vec4 = Eigen::Array<T, 4, 1>;  // one SIMD register in single precision

  static Vec4 Load(const T* address) { return Eigen::Map<const Vec4>(address); }
  static T Sum(const Vec4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

  // Cubic B-spline basis at the four samples around a point, t in [0, 1) from the second of them.
  static Vec4 Weights(T t) {
    constexpr T k6 = T(1) / T(6);
    const Vec4 c0(k6, 4 * k6, k6, T(0));
    const Vec4 c1(T(-0.5), T(0), T(0.5), T(0));
    const Vec4 c2(T(0.5), T(-1), T(0.5), T(0));
    const Vec4 c3(-k6, T(0.5), T(-0.5), k6);
    return ((c3 * t + c2) * t + c1) * t + c0;
  }
  static Vec4 Slopes(T t) {
    const Vec4 c1(T(-0.5), T(0), T(0.5), T(0));
    const Vec4 c2(T(1), T(-2), T(1), T(0));
    const Vec4 c3(T(-0.5), T(1.5), T(-1.5), T(0.5));
    return (c3 * t + c2) * t + c1;
  }

  // First of the 4x4 coefficients around (x, y) and the fractions within the middle cell.
  const T* Locate(T x, T y, T* tx, T* ty, bool* inside) const {
    const T low = T(2 - kPadding);
    const T column = std::min(std::max(x - T(0.5), low), T(width_ + kPadding - 3));
    const T row = std::min(std::max(y - T(0.5), low), T(height_ + kPadding - 3));
    *inside = column == x - T(0.5) && row == y - T(0.5);
    // The padding makes both sums positive, so truncation is floor.
    const int c = static_cast<int>(column + T(kPadding));
    const int r = static_cast<int>(row + T(kPadding));
    *tx = column + T(kPadding) - T(c);
    *ty = row + T(kPadding) - T(r);
    return coefficients_.data() + static_cast<size_t>(r - 1) * stride_ + (c - 1);
  }

  int width_ = 0;
  int height_ = 0;
  size_t stride_ = 0;
  std::vector<T> coefficients_;
};

extern template class SplineImage<float>;
extern template class SplineImage<double>;

}  // namespace burin
