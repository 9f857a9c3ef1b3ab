#include "costs/silhouette_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace burin {
namespace {

// In pixels of the level.
constexpr double kSigma = 0.8;
constexpr double kSampleLength = 0.5;
constexpr int kReach =
    4;  // half the side of a sample's box: 2.5 sigma, and where the contour moves to

constexpr double kAlong = 2;   // farther along the contour a sample has no effect, 2.5 sigma
constexpr double kLoss = 0.5;  // c
// An outline farther from a contour is not its own.
constexpr int kMatch = 4;
// A part of the surface that is less across has no window, and both its contours are in one another's blur.
constexpr double kThin = 3;
// Lines y = const a pixel, at most.
constexpr int kMostRows = 64;
constexpr double kPi = 3.14159265358979323846;
constexpr double kWeight = 2 * 1.7724538509055160273 * kSigma;  // W

// The integral of the unit Gaussian of `sigma` from minus infinity.
double Integral(double x) { return 0.5 * (1 + std::erf(x / (std::sqrt(2.0) * kSigma))); }

double Density(double x) {
  return std::exp(-0.5 * x * x / (kSigma * kSigma)) / (std::sqrt(2 * kPi) * kSigma);
}

// The pixels within kMatch of an outline: of one that is half object or more, and of one that is less.
cv::Mat1b NearOutlines(const cv::Mat1f& object) {
  const cv::Mat1b inside(object >= 0.5F);
  const cv::Mat disc =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kMatch + 1, 2 * kMatch + 1});
  cv::Mat1b grown, shrunk;
  cv::dilate(inside, grown, disc);
  cv::erode(inside, shrunk, disc);
  return grown & ~shrunk;
}

double Median(std::vector<double>* values) {
  if (values->empty()) return 0;
  const auto middle = values->begin() + static_cast<long>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

SilhouetteView::SilhouetteView(const LevelView& view, const TriangleMesh& mesh,
                               const EdgeFacets& edges, int level)
    : view_(&view), camera_(view.camera) {
  cover_.emplace(mesh, edges, camera_, std::min(8 << level, kMostRows));
  TakeContour(edges);
}

void SilhouetteView::TakeContour(const EdgeFacets& edges) {
  const cv::Mat1b matched = NearOutlines(view_->object);
  // Rows are what the contour's outside is told by: a little more than one of them.
  const double outwards = 1.6 / cover_->rows();
  int last = -1;
  for (const MeshCover::Sample& piece : cover_->Contour(kSampleLength, outwards)) {
    if (piece.rim != last) {
      const MeshCover::Rim& rim = cover_->rims()[piece.rim];
      const auto first = static_cast<int>(samples_.size());
      rims_.push_back({rim.edge, edges.a(rim.edge), edges.b(rim.edge), rim.outward, first, first});
      last = piece.rim;
    }
    rims_.back().thin |= cover_->IsThin(piece, kThin);
    fit_.contour_px += piece.length;
    const cv::Point pixel(static_cast<int>(piece.point.x()), static_cast<int>(piece.point.y()));
    if (matched(pixel) == 0) {
      fit_.unmatched += piece.length;
      continue;
    }
    samples_.push_back({piece.point, piece.along, piece.length, {}});
    ++rims_.back().end;
  }
  if (fit_.contour_px > 0) fit_.unmatched /= fit_.contour_px;
}

void SilhouetteView::Compare(const std::vector<char>& without) {
  std::vector<Rim> kept;
  std::vector<Sample> samples;
  for (const Rim& rim : rims_) {
    if (rim.begin == rim.end || without[rim.a] != 0 || without[rim.b] != 0) continue;
    Rim& now = kept.emplace_back(rim);
    now.begin = static_cast<int>(samples.size());
    samples.insert(samples.end(), samples_.begin() + rim.begin, samples_.begin() + rim.end);
    now.end = static_cast<int>(samples.size());
  }
  rims_ = std::move(kept);
  samples_ = std::move(samples);
  if (!samples_.empty()) {
    FindRegion();
    CompareAtStart();
  }
  cover_.reset();
}

void SilhouetteView::FindRegion() {
  Eigen::AlignedBox2d all;
  for (const Sample& sample : samples_) all.extend(sample.point);
  const auto around = [](const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    const cv::Point first(static_cast<int>(low.x()) - kReach, static_cast<int>(low.y()) - kReach);
    const cv::Point last(static_cast<int>(high.x()) + kReach, static_cast<int>(high.y()) + kReach);
    return cv::Rect(first, last + cv::Point(1, 1));
  };
  region_ = around(all.min(), all.max()) & cv::Rect(0, 0, camera_.width, camera_.height);
  for (Sample& sample : samples_) {
    sample.box = (around(sample.point, sample.point) & region_) - region_.tl();
  }
}

template <typename Use>
void SilhouetteView::ForEachPixel(const Sample& sample, const Eigen::Vector2d& outward,
                                  const Use& use) const {
  for (int y = sample.box.y; y < sample.box.y + sample.box.height; ++y) {
    for (int x = sample.box.x; x < sample.box.x + sample.box.width; ++x) {
      const size_t pixel = static_cast<size_t>(y) * region_.width + x;
      if (counts_[pixel] == 0) continue;
      const double dx = region_.x + x + 0.5 - sample.point.x();
      const double dy = region_.y + y + 0.5 - sample.point.y();
      const double along = dx * outward.y() - dy * outward.x();
      if (std::abs(along) > kAlong) continue;
      use(pixel, dx * outward.x() + dy * outward.y(), along);
    }
  }
}

void SilhouetteView::CompareAtStart() {
  // Blurred with what lies around the region too.
  const cv::Rect around = cv::Rect(region_.x - kReach, region_.y - kReach,
                                   region_.width + 2 * kReach, region_.height + 2 * kReach) &
                          cv::Rect(0, 0, camera_.width, camera_.height);
  const cv::Mat1f share = cover_->Share(around);
  const cv::Mat1f mask = view_->object(around);
  const double pixel_variance = 1.0 / 12;  // both are means over pixels
  cv::Mat1f difference;
  cv::GaussianBlur(cv::Mat1f(share - mask), difference, cv::Size(4 * kReach + 1, 4 * kReach + 1),
                   std::sqrt(kSigma * kSigma - pixel_variance), 0, cv::BORDER_REPLICATE);
  const cv::Rect inside(region_.x - around.x, region_.y - around.y, region_.width, region_.height);
  difference = difference(inside);
  counts_.assign(static_cast<size_t>(region_.area()), 0);
  for (const Sample& sample : samples_) {
    for (int y = sample.box.y; y < sample.box.y + sample.box.height; ++y) {
      std::fill_n(counts_.begin() + static_cast<long>(y) * region_.width + sample.box.x,
                  sample.box.width, 1);
    }
  }
  if (!view_->photographed.empty()) {
    cv::Mat1b known;
    cv::erode(view_->photographed(around), known, cv::Mat(), cv::Point(-1, -1), kReach);
    known = known(inside);
    for (int y = 0; y < region_.height; ++y) {
      for (int x = 0; x < region_.width; ++x) {
        if (known(y, x) == 0) counts_[static_cast<size_t>(y) * region_.width + x] = 0;
      }
    }
  }
  double common = 0;
  double both = 0;
  start_.resize(counts_.size());
  for (int y = 0; y < region_.height; ++y) {
    for (int x = 0; x < region_.width; ++x) {
      const size_t pixel = static_cast<size_t>(y) * region_.width + x;
      start_[pixel] = difference(y, x);
      if (counts_[pixel] == 0) continue;
      const float covered = share(y + inside.y, x + inside.x);
      const float object = mask(y + inside.y, x + inside.x);
      common += std::min(covered, object);
      both += std::max(covered, object);
    }
  }
  fit_.intersection_share = both > 0 ? common / both : 0;
  Judge(difference);
  for (const Rim& rim : rims_) {
    for (int s = rim.begin; s < rim.end; ++s) {
      const Sample& sample = samples_[s];
      ForEachPixel(sample, rim.outward, [&](size_t pixel, double across, double along) {
        start_[pixel] += sample.length * Density(along) * Integral(across);
      });
    }
  }
}

void SilhouetteView::Judge(const cv::Mat1f& difference) {
  std::vector<double> offsets;
  for (const Rim& rim : rims_) {
    for (int s = rim.begin; s < rim.end; ++s) {
      const Sample& sample = samples_[s];
      double mean = 0;
      ForEachPixel(sample, rim.outward, [&](size_t pixel, double across, double along) {
        const int y = static_cast<int>(pixel) / region_.width;
        const int x = static_cast<int>(pixel) % region_.width;
        mean += difference(y, x) * Density(across) * Density(along);
      });
      offsets.push_back(kWeight * mean);
    }
  }
  fit_.signed_px = Median(&offsets);
}

double SilhouetteView::Evaluate(const std::vector<Eigen::Vector3d>& vertices,
                                std::vector<RimSums>* sums) const {
  sums->assign(rims_.size(), RimSums());
  if (samples_.empty()) return 0;
  static thread_local std::vector<double> difference;  // e_p
  static thread_local std::vector<double> density;     // S_p
  static thread_local std::vector<double> weights;     // G_ps, sample by sample
  difference = start_;
  density.assign(start_.size(), 0.0);
  weights.clear();
  for (const Rim& rim : rims_) {
    const Eigen::Vector2d a = camera_.Project(vertices[rim.a]);
    const Eigen::Vector2d b = camera_.Project(vertices[rim.b]);
    for (int s = rim.begin; s < rim.end; ++s) {
      const Sample& sample = samples_[s];
      const double moved =
          rim.outward.dot((1 - sample.along) * a + sample.along * b - sample.point);
      ForEachPixel(sample, rim.outward, [&](size_t pixel, double across, double along) {
        const double line = sample.length * Density(along);
        difference[pixel] -= line * Integral(across - moved);
        const double weight = line * Density(across - moved);
        density[pixel] += weight;
        weights.push_back(weight);
      });
    }
  }
  // rho' of every pixel in place of nothing: it is asked for by every sample that reaches it.
  static thread_local std::vector<double> slope;  // rho'
  slope.resize(start_.size());
  double rest = 0;
  constexpr double kUnreached = 1e-9;
  for (size_t pixel = 0; pixel < start_.size(); ++pixel) {
    const double squared = difference[pixel] * difference[pixel] / (kLoss * kLoss);
    slope[pixel] = 1 / (1 + squared);
    if (counts_[pixel] != 0 && density[pixel] <= kUnreached) rest += std::log1p(squared);
  }
  const double* weight = weights.data();
  for (size_t r = 0; r < rims_.size(); ++r) {
    const Rim& rim = rims_[r];
    RimSums& sum = (*sums)[r];
    for (int s = rim.begin; s < rim.end; ++s) {
      double k = 0;
      double h = 0;
      ForEachPixel(
          samples_[s], rim.outward, [&](size_t pixel, double /*across*/, double /*along*/) {
            const double g = *weight++;
            k += slope[pixel] * difference[pixel] * g;
            h += slope[pixel] * density[pixel] * g;
            if (density[pixel] > kUnreached) {
              sum.energy +=
                  0.5 * kWeight * kLoss * kLoss * -std::log(slope[pixel]) * g / density[pixel];
            }
          });
      const double t = samples_[s].along;
      sum.slope[0] += kWeight * k * (1 - t);
      sum.slope[1] += kWeight * k * t;
      sum.curvature[0] += kWeight * h * (1 - t) * (1 - t);
      sum.curvature[1] += kWeight * h * (1 - t) * t;
      sum.curvature[2] += kWeight * h * t * t;
    }
  }
  return 0.5 * kWeight * kLoss * kLoss * rest;
}

}  // namespace burin
