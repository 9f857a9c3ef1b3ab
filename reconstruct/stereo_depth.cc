#include "reconstruct/stereo_depth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "reconstruct/rectified_pair.h"

namespace burin {
namespace {

constexpr int kBlock = 5;
constexpr float kMostStep = 1;  // of disparity among the four that are interpolated, pixels

cv::Mat Sampled(const cv::Mat& gray, const cv::Mat2f& places) {
  cv::Mat bytes;
  gray.convertTo(bytes, CV_8U);
  cv::Mat sampled;
  cv::remap(bytes, sampled, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return sampled;
}

// Disparities of the first picture; below pair.min_disparity where there is none.
cv::Mat1f Disparities(const RectifiedPair& pair, const View& first, const View& second) {
  // Without a border the matcher leaves out columns whose largest disparity is off the other picture.
  const int left = std::max(0, pair.min_disparity + pair.disparity_count);
  const int right = std::max(0, -pair.min_disparity);
  cv::Mat pictures[2];
  const View* views[2] = {&first, &second};
  for (int k = 0; k < 2; ++k) {
    cv::copyMakeBorder(Sampled(views[k]->gray, pair.SamplePlaces(k, views[k]->camera)), pictures[k],
                       0, 0, left, right, cv::BORDER_CONSTANT);
  }
  const auto matcher = cv::StereoSGBM::create(
      pair.min_disparity, pair.disparity_count, kBlock, /*P1=*/8 * kBlock * kBlock,
      /*P2=*/32 * kBlock * kBlock, /*disp12MaxDiff=*/1, /*preFilterCap=*/31, /*uniquenessRatio=*/8,
      /*speckleWindowSize=*/60, /*speckleRange=*/2, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat sixteenths;
  matcher->compute(pictures[0], pictures[1], sixteenths);
  cv::Mat1f disparities;
  sixteenths(cv::Rect(left, 0, pair.width, pair.height))
      .convertTo(disparities, CV_32F, 1.0 / cv::StereoMatcher::DISP_SCALE);
  return disparities;
}

// Between four elements that are all known and nearly the same; else nothing.
std::optional<double> Interpolated(const cv::Mat1f& disparities, float least, double column,
                                   double row) {
  const int x = static_cast<int>(std::floor(column));
  const int y = static_cast<int>(std::floor(row));
  if (x < 0 || y < 0 || x + 1 >= disparities.cols || y + 1 >= disparities.rows) return std::nullopt;
  const float d[4] = {disparities(y, x), disparities(y, x + 1), disparities(y + 1, x),
                      disparities(y + 1, x + 1)};
  const auto [low, high] = std::minmax_element(d, d + 4);
  if (*low < least || *high - *low > kMostStep) return std::nullopt;
  const double u = column - x;
  const double v = row - y;
  return (1 - v) * ((1 - u) * d[0] + u * d[1]) + v * ((1 - u) * d[2] + u * d[3]);
}

}  // namespace

DepthMap MatchPair(const View& first, const View& second,
                   const std::vector<Eigen::Vector3d>& points) {
  const Camera& camera = first.camera;
  DepthMap map;
  const std::optional<RectifiedPair> pair = Rectify(camera, second.camera, points);
  if (!pair.has_value()) return map;
  const cv::Mat1f disparities = Disparities(*pair, first, second);
  const auto least = static_cast<float>(pair->min_disparity);
  map.depth = cv::Mat1f::zeros(camera.height, camera.width);
  map.sigma = cv::Mat1f::zeros(camera.height, camera.width);
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Eigen::Vector3d ray = pair->rotation * camera.Ray(column + 0.5, row + 0.5);
      if (ray.z() <= 0) continue;
      const std::optional<double> disparity =
          Interpolated(disparities, least, pair->focal * ray.x() / ray.z() + pair->shift[0],
                       pair->focal * ray.y() / ray.z() + pair->row_shift);
      if (!disparity.has_value()) continue;
      const double inverse = pair->InverseDepth(*disparity);
      if (inverse <= 0) continue;
      const double z = 1 / (inverse * ray.z());
      map.depth(row, column) = static_cast<float>(z);
      map.sigma(row, column) = static_cast<float>(z * z * ray.z() / (pair->focal * pair->baseline));
    }
  }
  return map;
}

FusedDepth FusePairs(const std::vector<DepthMap>& pairs, const cv::Mat& mask, int least) {
  FusedDepth fused;
  std::vector<int> bit_of;  // of those that have a map
  for (size_t k = 0; k < pairs.size(); ++k) {
    if (!pairs[k].depth.empty()) bit_of.push_back(static_cast<int>(k));
  }
  if (bit_of.empty()) return fused;
  const cv::Size size = pairs[bit_of[0]].depth.size();
  fused.map.depth = cv::Mat1f::zeros(size);
  fused.map.sigma = cv::Mat1f::zeros(size);
  fused.pairs = cv::Mat1i::zeros(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      if (!mask.empty() && mask.at<std::uint8_t>(row, column) == 0) continue;
      int most = least - 1;
      for (const int a : bit_of) {
        const float depth = pairs[a].depth(row, column);
        if (depth <= 0) continue;
        int agreeing = 0;
        int bits = 0;
        double weights = 0;
        double sum = 0;
        for (const int b : bit_of) {
          const float other = pairs[b].depth(row, column);
          const float sigma = pairs[b].sigma(row, column);
          if (other <= 0 ||
              std::abs(other - depth) >= std::max(sigma, pairs[a].sigma(row, column))) {
            continue;
          }
          ++agreeing;
          bits |= 1 << b;
          const double weight = 1 / (static_cast<double>(sigma) * sigma);
          weights += weight;
          sum += weight * other;
        }
        if (agreeing <= most) continue;
        most = agreeing;
        fused.map.depth(row, column) = static_cast<float>(sum / weights);
        fused.map.sigma(row, column) = static_cast<float>(1 / std::sqrt(weights));
        fused.pairs(row, column) = bits;
      }
    }
  }
  return fused;
}

}  // namespace burin
