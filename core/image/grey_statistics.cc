#include "core/image/grey_statistics.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace burin {
namespace {

constexpr int kWindow = 5;
constexpr int kNoiseBlock = 16;
constexpr double kNoiseBlocks = 1024;
constexpr double kNoisePercentile = 0.2;
constexpr double kClippedShare = 1.0 / 254;

}  // namespace

double TextureContrast(const cv::Mat1f& image, const cv::Mat& mask) {
  const cv::Size window(kWindow, kWindow);
  cv::Mat1d mean;
  cv::Mat1d square;
  cv::boxFilter(image, mean, CV_64F, window);
  cv::sqrBoxFilter(image, square, CV_64F, window);
  cv::Mat whole;
  if (!mask.empty()) cv::erode(mask, whole, cv::Mat::ones(window, CV_8U));
  double squares = 0;
  double sum = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (!whole.empty() && whole.at<uint8_t>(y, x) == 0) continue;
      const double variance = std::max(0.0, square(y, x) - mean(y, x) * mean(y, x));
      squares += variance;
      sum += std::sqrt(variance);
    }
  }
  return sum > 0 ? squares / sum : 0;
}

double EstimateNoise(const cv::Mat1f& image, const cv::Mat& mask) {
  double darkest = 0;
  double brightest = 0;
  cv::minMaxLoc(image, &darkest, &brightest, nullptr, nullptr, mask);
  const double margin = kClippedShare * (brightest - darkest);
  const double blocks = static_cast<double>(image.total()) / (kNoiseBlock * kNoiseBlock);
  const int stride = kNoiseBlock * std::max(1, static_cast<int>(std::sqrt(blocks / kNoiseBlocks)));
  cv::Mat used;
  if (!mask.empty()) cv::erode(mask, used, cv::Mat());  // 3 x 3, the taps of a response
  std::vector<double> sigmas;
  for (int y0 = 1; y0 + kNoiseBlock < image.rows; y0 += stride) {
    for (int x0 = 1; x0 + kNoiseBlock < image.cols; x0 += stride) {
      const cv::Rect block(x0, y0, kNoiseBlock, kNoiseBlock);
      if (!used.empty() && cv::countNonZero(used(block)) < block.area()) continue;
      double sum = 0;
      bool clipped = false;
      for (int y = y0; y < y0 + kNoiseBlock; ++y) {
        const float* above = image[y - 1];
        const float* here = image[y];
        const float* below = image[y + 1];
        for (int x = x0; x < x0 + kNoiseBlock; ++x) {
          const double response = above[x - 1] - 2.0 * above[x] + above[x + 1] - 2.0 * here[x - 1] +
                                  4.0 * here[x] - 2.0 * here[x + 1] + below[x - 1] -
                                  2.0 * below[x] + below[x + 1];
          sum += response * response;
          clipped |= here[x] <= darkest + margin || here[x] >= brightest - margin;
        }
      }
      if (!clipped && sum > 0) {
        sigmas.push_back(std::sqrt(sum / (kNoiseBlock * kNoiseBlock)) / 6);
      }
    }
  }
  if (sigmas.empty()) return 0;
  const auto rank = static_cast<long>(kNoisePercentile * static_cast<double>(sigmas.size()));
  std::nth_element(sigmas.begin(), sigmas.begin() + rank, sigmas.end());
  return sigmas[rank];
}

}  // namespace burin
