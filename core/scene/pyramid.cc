#include "core/scene/pyramid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/image/grey_statistics.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

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

// Of the photograph at half its size, where sharp and soft photographs differ less than in full.
double PhotographContrast(const View& view, const cv::Mat1f& full) {
  const cv::Size size((full.cols + 1) / 2, (full.rows + 1) / 2);
  cv::Mat1f half;
  cv::resize(full, half, size, 0, 0, cv::INTER_AREA);
  return TextureContrast(half, view.mask.empty() ? cv::Mat() : ReducedMask(view.mask, size));
}

}  // namespace

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
      cv::Mat1f full;
      source.gray.convertTo(full, CV_32F);
      view.contrast = PhotographContrast(source, full);
      view.photo_noise_sigma = EstimateNoise(full);
      view.noise_sigma = view.photo_noise_sigma;
      if (size == source.gray.size()) {
        view.image = source.gray;  // shared, so that the finest level costs no memory
      } else {
        cv::Mat1f reduced;
        cv::resize(full, reduced, size, 0, 0, cv::INTER_AREA);
        view.image = reduced;
        view.noise_sigma = EstimateNoise(reduced);
      }
      if (!source.mask.empty()) view.mask = ReducedMask(source.mask, size);
      view.camera = source.camera.Resized(size.width, size.height).InScaledWorld(origin, scale);
    }
  });
  return views;
}

}  // namespace burin
