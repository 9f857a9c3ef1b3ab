#include "reconstruct/rectified_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

constexpr size_t kLeastPoints = 20;
constexpr double kBoxQuantile = 0.005;
constexpr double kDisparityQuantile = 0.003;
constexpr double kMargin = 0.15;
constexpr double kBoxMarginPx = 10;
constexpr double kDisparityMarginPx = 4;
constexpr int kLeastSize = 32;

struct Range {
  double low = 0;
  double high = 0;
  double Size() const { return high - low; }
  Range Within(const Range& other) const {
    return {std::max(low, other.low), std::min(high, other.high)};
  }
};

// Quantiles, and a margin around them.
Range Spread(std::vector<double> values, double quantile, double margin_px) {
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  const double low = values[static_cast<size_t>(std::lround(quantile * last))];
  const double high = values[static_cast<size_t>(std::lround((1 - quantile) * last))];
  const double margin = kMargin * (high - low) + margin_px;
  return {low - margin, high + margin};
}

// Columns and rows of the whole view in the rectified plane, without the shifts.
void WholeView(const Camera& camera, const Eigen::Matrix3d& rotation, double focal, Range* columns,
               Range* rows) {
  *columns = *rows = {1e30, -1e30};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d p =
        rotation * camera.Ray((k & 1) * camera.width, (k >> 1) * camera.height);
    const double depth = std::max(p.z(), 0.1);
    columns->low = std::min(columns->low, focal * p.x() / depth);
    columns->high = std::max(columns->high, focal * p.x() / depth);
    rows->low = std::min(rows->low, focal * p.y() / depth);
    rows->high = std::max(rows->high, focal * p.y() / depth);
  }
}

}  // namespace

cv::Mat2f RectifiedPair::SamplePlaces(int picture, const Camera& camera) const {
  cv::Mat2f places(height, width);
  const Eigen::Matrix3d camera_from_rectified = camera.rotation * rotation.transpose();
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const Eigen::Vector3d ray =
          camera_from_rectified *
          Eigen::Vector3d((column - shift[picture]) / focal, (row - row_shift) / focal, 1);
      const double depth = std::max(ray.z(), 1e-6);
      places(row, column) = {static_cast<float>(camera.fx * ray.x() / depth + camera.cx - 0.5),
                             static_cast<float>(camera.fy * ray.y() / depth + camera.cy - 0.5)};
    }
  }
  return places;
}

std::optional<RectifiedPair> Rectify(const Camera& first, const Camera& second,
                                     const std::vector<Eigen::Vector3d>& points) {
  const Camera* cameras[2] = {&first, &second};
  RectifiedPair pair;
  const Eigen::Vector3d baseline = second.Center() - first.Center();
  pair.baseline = baseline.norm();
  if (pair.baseline == 0) return std::nullopt;
  const Eigen::Vector3d x = baseline / pair.baseline;
  Eigen::Vector3d z = first.rotation.row(2) + second.rotation.row(2);
  z = (z - x * x.dot(z)).normalized();
  if (!z.allFinite()) return std::nullopt;
  pair.rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
  pair.focal = (std::sqrt(first.fx * first.fy) + std::sqrt(second.fx * second.fy)) / 2;
  std::vector<double> columns[2];
  std::vector<double> rows;
  std::vector<double> disparities;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d a = pair.rotation * (point - first.Center());
    const Eigen::Vector3d b = pair.rotation * (point - second.Center());
    if (a.z() <= 0 || b.z() <= 0) continue;
    columns[0].push_back(pair.focal * a.x() / a.z());
    columns[1].push_back(pair.focal * b.x() / b.z());
    rows.push_back(pair.focal * a.y() / a.z());
    disparities.push_back(columns[0].back() - columns[1].back());
  }
  if (rows.size() < kLeastPoints) return std::nullopt;
  Range height = Spread(rows, kBoxQuantile, kBoxMarginPx);
  double width = 0;
  for (int k = 0; k < 2; ++k) {
    Range whole_columns;
    Range whole_rows;
    WholeView(*cameras[k], pair.rotation, pair.focal, &whole_columns, &whole_rows);
    const Range used = Spread(columns[k], kBoxQuantile, kBoxMarginPx).Within(whole_columns);
    height = height.Within(whole_rows);
    pair.shift[k] = -used.low;
    width = std::max(width, used.Size());
  }
  const Range range = Spread(disparities, kDisparityQuantile, kDisparityMarginPx);
  const bool usable = width >= kLeastSize && height.Size() >= kLeastSize &&
                      width <= 2 * first.width + 64 && height.Size() <= 2 * first.height + 64 &&
                      range.Size() <= first.width;
  if (!usable) return std::nullopt;
  pair.row_shift = -height.low;
  pair.width = static_cast<int>(std::ceil(width));
  pair.height = static_cast<int>(std::ceil(height.Size()));
  const double offset = pair.shift[0] - pair.shift[1];
  pair.min_disparity = static_cast<int>(std::floor(range.low + offset));
  pair.disparity_count =
      16 * static_cast<int>(std::ceil((range.high + offset - pair.min_disparity) / 16));
  return pair;
}

}  // namespace burin
