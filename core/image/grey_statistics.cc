#include "core/image/grey_statistics.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace burin {
namespace {

constexpr int kWindow = 5;
constexpr double kSamples = 16384;  // of a photograph
constexpr double kOutside = 0.001;  // of the grey levels, at either end of the range
constexpr int kNoiseBlock = 16;
constexpr double kNoiseBlocks = 1024;
constexpr double kNoisePercentile = 0.2;
constexpr double kClippedShare = 1.0 / 254;

}  // namespace

GreySample SampleGreys(const cv::Mat1f& image, const cv::Mat& mask) {
  constexpr int kRadius = kWindow / 2;
  const int stride =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(image.total()) / kSamples)));
  GreySample sample;
  double squares = 0;
  double sum = 0;
  for (int y = kRadius; y + kRadius < image.rows; y += stride) {
    for (int x = kRadius; x + kRadius < image.cols; x += stride) {
      const cv::Rect window(x - kRadius, y - kRadius, kWindow, kWindow);
      if (!mask.empty() && cv::countNonZero(mask(window)) < kWindow * kWindow) continue;
      double mean = 0;
      for (const float level : image(window)) mean += level;
      mean /= kWindow * kWindow;
      double variance = 0;
      for (const float level : image(window)) variance += (level - mean) * (level - mean);
      variance /= kWindow * kWindow;
      squares += variance;
      sum += std::sqrt(variance);
      sample.levels.push_back(image(y, x));
    }
  }
  sample.texture = sum > 0 ? squares / sum : 0;
  return sample;
}

double Contrast(const std::vector<GreySample>& photographs) {
  std::vector<float> levels;
  std::vector<double> textures;
  for (const GreySample& photograph : photographs) {
    if (photograph.levels.empty()) continue;
    levels.insert(levels.end(), photograph.levels.begin(), photograph.levels.end());
    textures.push_back(photograph.texture);
  }
  if (levels.empty()) return 0;
  const auto at = [](auto* values, double share) {
    const auto rank = static_cast<long>(share * static_cast<double>(values->size() - 1));
    std::nth_element(values->begin(), values->begin() + rank, values->end());
    return static_cast<double>((*values)[rank]);
  };
  const double range = at(&levels, 1 - kOutside) - at(&levels, kOutside);
  return std::sqrt(range * at(&textures, 0.5));
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
