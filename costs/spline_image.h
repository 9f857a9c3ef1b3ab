// An image as a cubic B-spline: value and gradient at any point, twice continuously differentiable.
//
// The spline interpolates the samples (array element (row, col) is at image point (col+0.5, row+0.5)),
// with mirrored borders. Its coefficients come from the recursive prefilter with pole sqrt(3) - 2
// (Unser, "Splines: a perfect fit for signal and image processing", 1999). Bilinear sampling would
// leave kinks in the energy, on which line searches stall. A point further than kPadding - 2 pixels
// outside the image is clamped to there, each coordinate by itself; along a clamped one the gradient is
// zero.
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

  // Elements between rows of coefficients; element (row, col) is the sample's at
  // (row - kPadding, col - kPadding).
  size_t stride() const { return stride_; }
  const T* coefficients() const { return coefficients_.data(); }

  // Value at image point (x, y) and, unless null, its gradient (per pixel). One point; the kernel's
  // SampleSpline (costs/spline_simd-inl.h) is the same for a vector of them.
  void Sample(T x, T y, T* value, T* gradient_x = nullptr, T* gradient_y = nullptr) const {
    const T low = T(2 - kPadding);
    const T column = std::min(std::max(x - T(0.5), low), T(width_ + kPadding - 3));
    const T row = std::min(std::max(y - T(0.5), low), T(height_ + kPadding - 3));
    // The padding makes both sums positive, so truncation is floor.
    const int c = static_cast<int>(column + T(kPadding));
    const int r = static_cast<int>(row + T(kPadding));
    const Eigen::Array<T, 4, 1> weight_x = Weights(column + T(kPadding) - T(c));
    const Eigen::Array<T, 4, 1> weight_y = Weights(row + T(kPadding) - T(r));
    const Eigen::Array<T, 4, 1> slope_x = Slopes(column + T(kPadding) - T(c));
    const Eigen::Array<T, 4, 1> slope_y = Slopes(row + T(kPadding) - T(r));
    T sums[3] = {0, 0, 0};
    for (int k = 0; k < 4; ++k) {
      const T* line = coefficients_.data() + static_cast<size_t>(r - 1 + k) * stride_ + (c - 1);
      for (int m = 0; m < 4; ++m) {
        sums[0] += weight_y[k] * weight_x[m] * line[m];
        sums[1] += weight_y[k] * slope_x[m] * line[m];
        sums[2] += slope_y[k] * weight_x[m] * line[m];
      }
    }
    *value = sums[0];
    if (gradient_x != nullptr) *gradient_x = column == x - T(0.5) ? sums[1] : T(0);
    if (gradient_y != nullptr) *gradient_y = row == y - T(0.5) ? sums[2] : T(0);
  }

 private:
  // Cubic B-spline basis at the four samples around a point, t in [0, 1) from the second of them.
  static Eigen::Array<T, 4, 1> Weights(T t) {
    const T u = 1 - t;
    return {u * u * u / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * u * u + 3 * u * u * u) / 6,
            t * t * t / 6};
  }
  static Eigen::Array<T, 4, 1> Slopes(T t) {
    const T u = 1 - t;
    return {-u * u / 2, (3 * t * t - 4 * t) / 2, (4 * u - 3 * u * u) / 2, t * t / 2};
  }

  int width_ = 0;
  int height_ = 0;
  size_t stride_ = 0;
  std::vector<T> coefficients_;
};

extern template class SplineImage<float>;
extern template class SplineImage<double>;

}  // namespace burin
