#include "costs/spline_image.h"

namespace burin {
namespace {

// In-place prefilter of one line of n samples, `stride` apart, with mirrored borders.
template <typename T>
void PrefilterLine(T* line, int n, size_t stride) {
  if (n < 2) return;
  const double pole = std::sqrt(3.0) - 2.0;
  const double gain = 6.0;
  // Causal start: sum of pole^k * line[k], long enough for full precision.
  const int horizon = std::min(n, 40);
  double sum = 0;
  double power = 1;
  for (int k = 0; k < horizon; ++k, power *= pole) sum += power * line[k * stride];
  double previous = gain * sum;
  line[0] = static_cast<T>(previous);
  for (int k = 1; k < n; ++k) {
    previous = gain * line[k * stride] + pole * previous;
    line[k * stride] = static_cast<T>(previous);
  }
  previous = pole / (pole * pole - 1.0) *
             (line[(n - 1) * stride] + pole * static_cast<double>(line[(n - 2) * stride]));
  line[(n - 1) * stride] = static_cast<T>(previous);
  for (int k = n - 2; k >= 0; --k) {
    previous = pole * (previous - line[k * stride]);
    line[k * stride] = static_cast<T>(previous);
  }
}

int Mirror(int index, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1);
  index = ((index % period) + period) % period;
  return index < n ? index : period - index;
}

}  // namespace

template <typename T>
SplineImage<T>::SplineImage(const cv::Mat1f& image, T offset)
    : width_(image.cols), height_(image.rows), stride_(image.cols + 2 * kPadding) {
  coefficients_.resize(stride_ * (height_ + 2 * kPadding));
  T* origin = coefficients_.data() + kPadding * stride_ + kPadding;
  for (int y = 0; y < height_; ++y) {
    T* row = origin + y * stride_;
    for (int x = 0; x < width_; ++x) row[x] = static_cast<T>(image(y, x)) - offset;
    PrefilterLine(row, width_, 1);
  }
  for (int x = 0; x < width_; ++x) PrefilterLine(origin + x, height_, stride_);
  for (int y = -kPadding; y < height_ + kPadding; ++y) {
    const T* source = origin + Mirror(y, height_) * stride_;
    T* target = coefficients_.data() + (y + kPadding) * stride_;
    for (int x = -kPadding; x < width_ + kPadding; ++x) {
      target[x + kPadding] = source[Mirror(x, width_)];
    }
  }
}

template class SplineImage<float>;
template class SplineImage<double>;

}  // namespace burin
