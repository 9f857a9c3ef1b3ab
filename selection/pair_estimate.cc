#include "selection/pair_estimate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr size_t kPoints = 1024;     // of a view
constexpr size_t kFirstPoints = 64;  // in the first pass
constexpr size_t kFirstFactor = 4;   // partners that are left after it, for each one wanted
constexpr int kDepthMapPx = 128;     // longer side of a depth map
constexpr double kTolerancePx = 8;

struct Scored {
  double score;
  int partner;
};

// The `count` best, best first.
std::vector<int> Best(std::vector<Scored> scored, size_t count) {
  count = std::min(count, scored.size());
  std::partial_sort(scored.begin(), scored.begin() + static_cast<std::ptrdiff_t>(count),
                    scored.end(), [](const Scored& a, const Scored& b) {
                      return a.score != b.score ? a.score > b.score : a.partner < b.partner;
                    });
  std::vector<int> best;
  for (size_t k = 0; k < count; ++k) best.push_back(scored[k].partner);
  return best;
}

// Bits 0, 2, 4, ... of `bits`, side by side.
uint32_t EvenBits(uint64_t bits) {
  bits &= 0x5555555555555555;
  bits = (bits | bits >> 1) & 0x3333333333333333;
  bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0f;
  bits = (bits | bits >> 4) & 0x00ff00ff00ff00ff;
  bits = (bits | bits >> 8) & 0x0000ffff0000ffff;
  return static_cast<uint32_t>(bits | bits >> 16);
}

// Calls body(x, y) for the pixels of an image along a Morton curve.
template <typename Body>
void AlongMortonCurve(int width, int height, Body body) {
  uint64_t side = 1;
  while (side < static_cast<uint64_t>(std::max(width, height))) side *= 2;
  for (uint64_t code = 0; code < side * side; ++code) {
    const auto x = static_cast<int>(EvenBits(code));
    const auto y = static_cast<int>(EvenBits(code >> 1));
    if (x < width && y < height) body(x, y);
  }
}

}  // namespace

void PairEstimate::Look(int view, const Camera& camera, const cv::Mat& mask,
                        const cv::Mat1i& facets, const cv::Mat1f& inverse_depth, double seen) {
  SampledView& sampled = views_[view];
  sampled.camera = camera;
  sampled.projection = camera.ProjectionMatrix();
  sampled.center = camera.Center();
  sampled.focal_px = FocalPx(camera);
  sampled.seen = seen;
  sampled.mask = mask;
  const int stride = std::max(1, std::max(camera.width, camera.height) / kDepthMapPx);
  sampled.depth_stride = stride;
  sampled.inverse_depth.create((camera.height + stride - 1) / stride,
                               (camera.width + stride - 1) / stride);
  for (int y = 0; y < sampled.inverse_depth.rows; ++y) {
    for (int x = 0; x < sampled.inverse_depth.cols; ++x) {
      sampled.inverse_depth(y, x) = inverse_depth(y * stride, x * stride);
    }
  }
  std::vector<Pixel> pixels;
  AlongMortonCurve(facets.cols, facets.rows, [&](int x, int y) {
    if (facets(y, x) >= 0) pixels.push_back({y * facets.cols + x, facets(y, x)});
  });
  const size_t count = std::min(kPoints, pixels.size());
  for (size_t k = 0; k < count; ++k) {
    sampled.pixels.push_back(pixels[(2 * k + 1) * pixels.size() / (2 * count)]);
  }
}

std::vector<PairEstimate::Point> PairEstimate::PointsOf(const SampledView& view) const {
  std::vector<Point> points;
  for (const Pixel& pixel : view.pixels) {
    const Eigen::Vector3d normal = FaceAreaNormal(*mesh_, pixel.facet).normalized();
    const Eigen::Vector3d ray = view.camera.Ray(pixel.index % view.camera.width + 0.5,
                                                pixel.index / view.camera.width + 0.5);
    const Eigen::Vector3d& corner = mesh_->vertices[mesh_->faces[pixel.facet][0]];
    const double depth = normal.dot(corner - view.center) / normal.dot(ray);
    const Eigen::Vector3d position = view.center + depth * ray;
    points.push_back({position, normal, {view.center, view.focal_px, position, normal}});
  }
  return points;
}

bool PairEstimate::Sees(const SampledView& view, const Point& point) {
  if (!(point.normal.dot(view.center - point.position) > 0)) return false;
  const Eigen::Vector3d q = view.projection.leftCols<3>() * point.position + view.projection.col(3);
  const int width = view.camera.width;
  const int height = view.camera.height;
  const bool inside = q.z() > 0 && q.z() > view.camera.near_depth && q.x() >= 0 && q.y() >= 0 &&
                      q.x() <= width * q.z() && q.y() <= height * q.z();
  if (!inside) return false;
  const int column = std::min(static_cast<int>(q.x() / q.z()), width - 1);
  const int row = std::min(static_cast<int>(q.y() / q.z()), height - 1);
  if (!view.mask.empty() && view.mask.at<uint8_t>(row, column) == 0) return false;
  const double nearest = view.inverse_depth(row / view.depth_stride, column / view.depth_stride);
  return nearest * q.z() <= 1 + kTolerancePx / view.focal_px;
}

PairMeasure PairEstimate::Estimate(const std::vector<Point>& points, size_t stride, double seen,
                                   const SampledView& second) const {
  PairSums sums;
  size_t tried = 0;
  for (size_t k = stride / 2; k < points.size(); k += stride) {
    ++tried;
    const Point& point = points[k];
    if (!Sees(second, point)) continue;
    sums.Add(point.sight, {second.center, second.focal_px, point.position, point.normal}, range_);
  }
  return sums.Mean(static_cast<double>(tried) / seen);
}

std::vector<PartnerLists> PairEstimate::BestPartners(const std::vector<PairScore>& scores,
                                                     int count) const {
  const auto n = static_cast<int>(views_.size());
  const auto wanted = static_cast<size_t>(count);
  std::vector<PartnerLists> best(scores.size(), PartnerLists(n));
  ParallelFor(n, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::vector<Point> points = PointsOf(views_[i]);
      if (points.empty()) continue;
      const double seen = views_[i].seen;
      const auto score = [&](const std::vector<int>& partners, size_t stride) {
        std::vector<std::vector<Scored>> scored(scores.size());
        for (const int j : partners) {
          const PairMeasure measure = Estimate(points, stride, seen, views_[j]);
          for (size_t s = 0; s < scores.size(); ++s) {
            const double value = scores[s](measure, seen);
            if (value > 0) scored[s].push_back({value, j});
          }
        }
        return scored;
      };
      std::vector<int> partners;
      for (int j = 0; j < n; ++j) {
        if (j != i) partners.push_back(j);
      }
      const size_t stride = std::max<size_t>(1, points.size() / kFirstPoints);
      const std::vector<std::vector<Scored>> first = score(partners, stride);
      partners.clear();
      for (const std::vector<Scored>& scored : first) {
        for (const int j : Best(scored, kFirstFactor * wanted)) partners.push_back(j);
      }
      std::sort(partners.begin(), partners.end());
      partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
      const std::vector<std::vector<Scored>> second = score(partners, 1);
      for (size_t s = 0; s < scores.size(); ++s) best[s][i] = Best(second[s], wanted);
    }
  });
  return best;
}

}  // namespace burin
