#include "core/scene/pyramid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kNoiseBlock = 16;
constexpr double kNoisePercentile = 0.2;
constexpr int kSmallestSide = 16;

cv::Mat ReducedMask(const cv::Mat& mask, const cv::Size& size) {
  cv::Mat used;
  cv::Mat reduced;
  cv::Mat1f(mask != 0).copyTo(used);  // 0 or 255
  cv::resize(used, reduced, size, 0, 0, cv::INTER_AREA);
  cv::Mat whole = reduced > 254.9F;
  cv::erode(whole, whole, cv::Mat());  // 3 x 3; outside counts as used
  return whole;
}

}  // namespace

double EstimateNoise(const cv::Mat1f& image) {
  std::vector<double> sigmas;
  for (int y0 = 1; y0 + kNoiseBlock < image.rows; y0 += kNoiseBlock) {
    for (int x0 = 1; x0 + kNoiseBlock < image.cols; x0 += kNoiseBlock) {
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
          clipped |= here[x] <= 1 || here[x] >= 254;
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

std::vector<LevelView> MakeLevelViews(const Scene& scene, int level, const Eigen::Vector3d& origin,
                                      double scale) {
  std::vector<LevelView> views(scene.views.size());
  ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const View& source = scene.views[i];
      LevelView& view = views[i];
      const double shrink = std::ldexp(1.0, -level);
      const auto side = [shrink](int full) {
        return std::max(std::min(full, kSmallestSide),
                        static_cast<int>(std::lround(full * shrink)));
      };
      const cv::Size size(side(source.camera.width), side(source.camera.height));
      if (size == source.gray.size()) {
        view.image = source.gray;  // shared, so that the finest level costs no memory
      } else {
        cv::Mat full;
        cv::Mat reduced;
        source.gray.convertTo(full, CV_32F);
        cv::resize(full, reduced, size, 0, 0, cv::INTER_AREA);
        view.image = reduced;
      }
      if (!source.mask.empty()) view.mask = ReducedMask(source.mask, size);
      view.camera = source.camera.Resized(size.width, size.height).InScaledWorld(origin, scale);
      view.noise_sigma = EstimateNoise(view.FloatImage());
    }
  });
  return views;
}

}  // namespace burin
