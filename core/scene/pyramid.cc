#include "core/scene/pyramid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/image/grey_statistics.h"
#include "core/image/mask_cover.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kSmallestSide = 16;

// How far into a masked area the surroundings are carried: a cubic B-spline's sample sees a pixel at
// distance d by about 0.27^d.
constexpr int kFillRings = 10;

// 255 where the mask allows every pixel that a pixel of the reduced image is made of.
cv::Mat WholePixels(const cv::Mat& mask, const cv::Size& size) {
  return MaskCover(mask, size) > kWholePixel;
}

// The image with other values where `whole` is zero: ring by ring the mean of the neighbours known so
// far, and behind the rings the mean of all pixels that are whole.
cv::Mat1f FilledFromAround(const cv::Mat1f& image, const cv::Mat& whole) {
  cv::Mat1f filled(image.size(), static_cast<float>(cv::mean(image, whole)[0]));
  image.copyTo(filled, whole);
  cv::Mat1b known = whole.clone();
  for (int ring = 0; ring < kFillRings; ++ring) {
    const cv::Mat1b before = known.clone();
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        if (before(y, x) != 0) continue;
        double sum = 0;
        int count = 0;
        for (int v = std::max(0, y - 1); v <= std::min(image.rows - 1, y + 1); ++v) {
          for (int u = std::max(0, x - 1); u <= std::min(image.cols - 1, x + 1); ++u) {
            if (before(v, u) == 0) continue;
            sum += filled(v, u);
            ++count;
          }
        }
        if (count == 0) continue;
        filled(y, x) = static_cast<float>(sum / count);
        known(y, x) = 255;
      }
    }
  }
  return filled;
}

void ApplyMask(const cv::Mat& mask, LevelView* view) {
  const cv::Mat whole = WholePixels(mask, view->image.size());
  cv::Mat filled = FilledFromAround(view->FloatImage(), whole);
  filled.convertTo(view->image, view->image.type());
  cv::erode(whole, view->mask, cv::Mat());  // 3 x 3; outside counts as used
}

}  // namespace

std::vector<LevelView> MakeLevelViews(const Scene& scene, const std::vector<Camera>& cameras,
                                      const std::vector<ViewAtLevel>& level,
                                      const Eigen::Vector3d& origin, double scale) {
  std::vector<LevelView> views(scene.views.size());
  std::vector<GreySample> greys(views.size());
  ParallelFor(static_cast<int>(views.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const View& source = scene.views[i];
      LevelView& view = views[i];
      view.at = level[i];
      const double shrink = std::ldexp(1.0, -view.at.halvings);
      const auto side = [shrink](int full) {
        return std::max(std::min(full, kSmallestSide),
                        static_cast<int>(std::lround(full * shrink)));
      };
      const cv::Size size(side(cameras[i].width), side(cameras[i].height));
      cv::Mat1f full;
      source.gray.convertTo(full, CV_32F);
      greys[i] = SampleGreys(full, source.mask);
      view.photo_noise_sigma = EstimateNoise(full, source.mask);
      view.noise_sigma = view.photo_noise_sigma;
      if (size == source.gray.size()) {
        view.image = source.gray;  // shared, so that the finest level costs no memory
      } else {
        cv::Mat1f reduced;
        cv::resize(full, reduced, size, 0, 0, cv::INTER_AREA);
        view.image = reduced;
        view.noise_sigma = EstimateNoise(
            reduced, source.mask.empty() ? cv::Mat() : WholePixels(source.mask, size));
      }
      if (!source.mask.empty()) ApplyMask(source.mask, &view);
      if (!source.object.empty()) {
        cv::Mat1f object;
        source.object.convertTo(object, CV_32F, 1 / 255.0);
        cv::resize(object, view.object, size, 0, 0, cv::INTER_AREA);
      }
      if (!source.photographed.empty()) view.photographed = WholePixels(source.photographed, size);
      view.camera = cameras[i].Resized(size.width, size.height).InScaledWorld(origin, scale);
    }
  });
  const double contrast = Contrast(greys);
  for (LevelView& view : views) view.contrast = contrast;
  return views;
}

std::vector<LevelView> MakeLevelViews(const Scene& scene, int level, const Eigen::Vector3d& origin,
                                      double scale) {
  return MakeLevelViews(scene, CamerasOf(scene),
                        std::vector<ViewAtLevel>(scene.views.size(), {level}), origin, scale);
}

const LevelView& NamesLevel(const std::vector<LevelView>& views) {
  for (const LevelView& view : views) {
    if (view.at.takes_part && !view.at.coarse) return view;
  }
  return views[0];
}

}  // namespace burin
