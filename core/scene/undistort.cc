#include "core/scene/undistort.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace burin {
namespace {

// Catmull-Rom weights of the samples at -1, 0, 1, 2 for a point at t in [0, 1]; exact for
// quadratics.
std::array<float, 4> CubicWeights(float t) {
  return {0.5F * t * (-1 + t * (2 - t)), 0.5F * (2 + t * t * (3 * t - 5)),
          0.5F * t * (1 + t * (4 - 3 * t)), 0.5F * t * t * (t - 1)};
}

// Tap columns (or rows) and weights around coordinate x, 0 being the centre of the first sample.
struct Taps {
  std::array<int, 4> index;
  std::array<float, 4> weight;
  Taps(float x, int size) {
    const auto last = static_cast<float>(size - 1);
    x = x > 0 ? std::min(x, last) : 0;  // not-a-number becomes 0 as well
    const int first = std::min(static_cast<int>(x), std::max(size - 2, 0));
    weight = CubicWeights(x - static_cast<float>(first));
    for (int k = 0; k < 4; ++k) index[k] = std::clamp(first - 1 + k, 0, size - 1);
  }
};

template <typename T>
float Sample(const cv::Mat& image, float x, float y) {
  const Taps across(x, image.cols);
  const Taps down(y, image.rows);
  float sum = 0;
  for (int i = 0; i < 4; ++i) {
    const T* row = image.ptr<T>(down.index[i]);
    float row_sum = 0;
    for (int j = 0; j < 4; ++j) {
      row_sum += across.weight[j] * static_cast<float>(row[across.index[j]]);
    }
    sum += down.weight[i] * row_sum;
  }
  return sum;
}

template <typename T>
void SampleRows(const cv::Mat& image, const cv::Mat& map_x, const cv::Mat& map_y, int first_row,
                cv::Mat* result) {
  for (int i = 0; i < map_x.rows; ++i) {
    const auto* x = map_x.ptr<float>(i);
    const auto* y = map_y.ptr<float>(i);
    T* out = result->ptr<T>(first_row + i);
    for (int j = 0; j < map_x.cols; ++j) {
      out[j] = cv::saturate_cast<T>(Sample<T>(image, x[j], y[j]));
    }
  }
}

// Where pixels of the rows [first, first + rows) were photographed: r' (1 + k r'^2) = r by Newton's
// method, from r.
void MapOfMeasured(const Camera& camera, double k, int first, int rows, cv::Mat* map_x,
                   cv::Mat* map_y) {
  constexpr int kSteps = 20;
  map_x->create(rows, camera.width, CV_32FC1);
  map_y->create(rows, camera.width, CV_32FC1);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < camera.width; ++j) {
      const double u = (j + 0.5 - camera.cx) / camera.fx;
      const double v = (first + i + 0.5 - camera.cy) / camera.fy;
      const double r = std::hypot(u, v);
      double photographed = r;
      for (int step = 0; step < kSteps; ++step) {
        const double slope = 1 + 3 * k * photographed * photographed;
        if (slope <= 0) break;  // beyond where the lens folds back
        photographed -= (photographed * (1 + k * photographed * photographed) - r) / slope;
      }
      const double scale = r > 0 ? photographed / r : 1;
      map_x->at<float>(i, j) = static_cast<float>(u * scale * camera.fx + camera.cx - 0.5);
      map_y->at<float>(i, j) = static_cast<float>(v * scale * camera.fy + camera.cy - 0.5);
    }
  }
}

// Where every pixel was photographed, 64 rows at a time (the maps of a whole photograph would be eight
// times its size): use(first row, map of x, map of y).
template <typename Use>
void ForEachBand(const Camera& camera, const Lens& lens, const Use& use) {
  // OpenCV has the centre of the top-left pixel at (0, 0), burin at (0.5, 0.5).
  const cv::Matx33d intrinsics(camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0,
                               1);
  const cv::Vec<double, 5> coefficients(lens.brown.data());
  constexpr int kRowsAtOnce = 64;
  for (int row = 0; row < camera.height; row += kRowsAtOnce) {
    const int rows = std::min(kRowsAtOnce, camera.height - row);
    cv::Matx33d of_rows = intrinsics;
    of_rows(1, 2) -= row;
    cv::Mat map_x, map_y;
    if (lens.measured != 0) {
      MapOfMeasured(camera, lens.measured, row, rows, &map_x, &map_y);
    } else {
      cv::initUndistortRectifyMap(intrinsics, coefficients, cv::noArray(), of_rows,
                                  cv::Size(camera.width, rows), CV_32FC1, map_x, map_y);
    }
    use(row, map_x, map_y);
  }
}

}  // namespace

cv::Mat Undistort(const cv::Mat& gray, const Camera& camera, const Lens& lens) {
  CHECK(gray.type() == CV_8UC1 || gray.type() == CV_32FC1);
  CHECK(gray.cols == camera.width && gray.rows == camera.height);
  cv::Mat result(gray.size(), gray.type());
  ForEachBand(camera, lens, [&](int row, const cv::Mat& map_x, const cv::Mat& map_y) {
    if (gray.type() == CV_8UC1) {
      SampleRows<unsigned char>(gray, map_x, map_y, row, &result);
    } else {
      SampleRows<float>(gray, map_x, map_y, row, &result);
    }
  });
  return result;
}

double CornerRadius(const Camera& camera) {
  return std::hypot(std::max(camera.cx, camera.width - camera.cx) / camera.fx,
                    std::max(camera.cy, camera.height - camera.cy) / camera.fy);
}

double FoldRadius(const Lens& lens, double largest) {
  if (lens.measured != 0) {
    // r (1 + k r^2) stops growing at r^2 = -1 / (3 k).
    return lens.measured > 0 ? largest : 2.0 / 3 * std::sqrt(-1 / (3 * lens.measured));
  }
  const auto& [k1, k2, p1, p2, k3] = lens.brown;
  constexpr int kSteps = 4096;
  for (int step = 0; step <= kSteps; ++step) {
    const double r2 = std::pow(largest * step / kSteps, 2);
    if (!(1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3)) > 0)) return largest * step / kSteps;
  }
  return largest;
}

cv::Mat PhotographedPixels(const Camera& camera, const Lens& lens) {
  const double fold = FoldRadius(lens, CornerRadius(camera));
  cv::Mat result(camera.height, camera.width, CV_8UC1);
  ForEachBand(camera, lens, [&](int row, const cv::Mat& map_x, const cv::Mat& map_y) {
    for (int i = 0; i < map_x.rows; ++i) {
      const auto* x = map_x.ptr<float>(i);
      const auto* y = map_y.ptr<float>(i);
      const double v = (row + i + 0.5 - camera.cy) / camera.fy;
      for (int j = 0; j < map_x.cols; ++j) {
        const double u = (j + 0.5 - camera.cx) / camera.fx;
        // Half a pixel around the outermost centres is still the photograph.
        const bool inside = x[j] >= -0.5F && y[j] >= -0.5F &&
                            x[j] <= static_cast<float>(camera.width) - 0.5F &&
                            y[j] <= static_cast<float>(camera.height) - 0.5F;
        result.at<unsigned char>(row + i, j) = inside && std::hypot(u, v) <= fold ? 255 : 0;
      }
    }
  });
  return result;
}

}  // namespace burin
