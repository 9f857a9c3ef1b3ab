#include "reconstruct/dense_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr double kAgreeSigmas = 1.5 * 1.4142135623730951;
constexpr double kTakenSigmas = 3;  // a square is taken by a point that near to its depth
constexpr size_t kMostSights = 8;
constexpr int kPointsPerItem = 1024;

// The pixel of a view that a point projects into, and its depth there.
struct Place {
  int row = -1;
  int column = -1;
  double depth = 0;
};

Place PlaceOf(const Camera& camera, const Eigen::Vector3d& point) {
  Place place;
  place.depth = camera.Depth(point);
  if (place.depth <= 0) return place;
  const Eigen::Vector2d at = camera.Project(point);
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < camera.width && at.y() < camera.height)) {
    return place;
  }
  place.column = static_cast<int>(at.x());
  place.row = static_cast<int>(at.y());
  return place;
}

int CountBits(int bits) {
  int count = 0;
  for (; bits != 0; bits &= bits - 1) ++count;
  return count;
}

struct Candidate {
  Eigen::Vector3d position;
  std::vector<int> views;
  bool confirmed = false;
};

class Squares {
 public:
  Squares(const FusedDepth& depth, int spacing)
      : depth_(depth),
        spacing_(spacing),
        columns_((depth.map.depth.cols + spacing - 1) / spacing),
        rows_((depth.map.depth.rows + spacing - 1) / spacing),
        taken_(static_cast<size_t>(columns_) * rows_, 0) {}

  void Take(const Camera& camera, const Eigen::Vector3d& point) {
    const Place place = PlaceOf(camera, point);
    if (place.row < 0) return;
    const float depth = depth_.map.depth(place.row, place.column);
    if (depth > 0 &&
        std::abs(depth - place.depth) < kTakenSigmas * depth_.map.sigma(place.row, place.column)) {
      taken_[static_cast<size_t>(place.row / spacing_) * columns_ + place.column / spacing_] = 1;
    }
  }

  // The pixels of squares that are not taken, in which most pairs agree.
  std::vector<cv::Point> Best() const {
    std::vector<cv::Point> best;
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < columns_; ++c) {
        if (taken_[static_cast<size_t>(r) * columns_ + c] != 0) continue;
        int most = 0;
        cv::Point at;
        for (int y = r * spacing_; y < std::min((r + 1) * spacing_, depth_.pairs.rows); ++y) {
          for (int x = c * spacing_; x < std::min((c + 1) * spacing_, depth_.pairs.cols); ++x) {
            const int agreeing = CountBits(depth_.pairs(y, x));
            if (agreeing <= most) continue;
            most = agreeing;
            at = {x, y};
          }
        }
        if (most > 0) best.push_back(at);
      }
    }
    return best;
  }

 private:
  const FusedDepth& depth_;
  int spacing_;
  int columns_;
  int rows_;
  std::vector<char> taken_;
};

Candidate CandidateAt(const Scene& scene, const std::vector<FusedDepth>& depths,
                      const DenseRules& rules, int view, const cv::Point& pixel) {
  const FusedDepth& own = depths[view];
  const Camera& camera = scene.views[view].camera;
  const double sigma = own.map.sigma(pixel);
  Candidate candidate;
  candidate.position =
      camera.Center() + own.map.depth(pixel) * camera.Ray(pixel.x + 0.5, pixel.y + 0.5);
  candidate.views = {view};
  for (size_t k = 0; k < own.partners.size(); ++k) {
    const bool agrees = (own.pairs(pixel) >> k & 1) != 0;
    if (agrees && scene.views[own.partners[k]].camera.Depth(candidate.position) > 0) {
      candidate.views.push_back(own.partners[k]);
    }
  }
  int confirming = 0;
  for (int other = 0; other < static_cast<int>(depths.size()); ++other) {
    if (other == view || depths[other].map.depth.empty()) continue;
    const Place place = PlaceOf(scene.views[other].camera, candidate.position);
    if (place.row < 0) continue;
    const DepthMap& map = depths[other].map;
    const float depth = map.depth(place.row, place.column);
    const double allowed =
        kAgreeSigmas * std::max<double>(sigma, map.sigma(place.row, place.column));
    if (depth <= 0 || std::abs(depth - place.depth) >= allowed) continue;
    ++confirming;
    candidate.views.push_back(other);
  }
  candidate.confirmed = confirming >= rules.confirming_views;
  std::sort(candidate.views.begin(), candidate.views.end());
  candidate.views.erase(std::unique(candidate.views.begin(), candidate.views.end()),
                        candidate.views.end());
  if (candidate.views.size() > kMostSights) candidate.views.resize(kMostSights);
  return candidate;
}

}  // namespace

void AddDensePoints(const Scene& scene, const std::vector<FusedDepth>& depths,
                    const DenseRules& rules, SightedPoints* points) {
  const std::vector<Camera> cameras = CamerasOf(scene);
  std::vector<int> known(depths.size(), 0);
  for (size_t v = 0; v < depths.size(); ++v) {
    if (!depths[v].map.depth.empty()) known[v] = cv::countNonZero(depths[v].map.depth);
  }
  std::vector<int> order(depths.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return known[a] > known[b]; });
  for (const int view : order) {
    if (known[view] == 0) continue;
    Squares squares(depths[view], rules.spacing_px);
    for (const Eigen::Vector3d& point : points->positions) squares.Take(cameras[view], point);
    const std::vector<cv::Point> pixels = squares.Best();
    std::vector<Candidate> candidates(pixels.size());
    ParallelFor(static_cast<int>(pixels.size()), kPointsPerItem, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        candidates[k] = CandidateAt(scene, depths, rules, view, pixels[k]);
      }
    });
    for (const Candidate& candidate : candidates) {
      if (candidate.confirmed) points->Add(candidate.position, candidate.views, cameras);
    }
  }
}

}  // namespace burin
