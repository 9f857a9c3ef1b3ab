// Which partners of a view are worth measuring, told from some of its points and without rays.
//
// A view's points are kPoints of its front pixels, at even distances along a curve that keeps neighbours
// together. A partner is taken to see a point that faces it, projects into its image, on a pixel that its mask
// allows, and lies no more than kTolerancePx pixel footprints behind what its depth map has there. Two passes:
// every other view is scored by kFirstPoints of them, and the best by all, kFirstFactor times as many as are
// wanted. The first pass grows with the square of the number of views, at some microseconds a pair.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "selection/pair_sums.h"
#include "selection/pair_terms.h"

namespace burin {

// A pair's score by its measures and PairSurvey::seen of its reference: more is better, 0 = no candidate.
using PairScore = std::function<double(const PairMeasure& measure, double seen)>;

// Of every view partners, best first.
using PartnerLists = std::vector<std::vector<int>>;

class PairEstimate {
 public:
  // `mesh` must outlive this.
  PairEstimate(const TriangleMesh& mesh, int view_count, const ParallaxRange& range)
      : mesh_(&mesh), views_(view_count), range_(range) {}

  // What a view sees: the facet of each pixel, -1 where it sees no front side or its mask forbids it;
  // 1/depth of what is there, 0 = nothing; the share of its pixels with a facet. Calls for different views may
  // run at the same time.
  void Look(int view, const Camera& camera, const cv::Mat& mask, const cv::Mat1i& facets,
            const cv::Mat1f& inverse_depth, double seen);

  // For each of `scores` the best `count` partners of every view, ties by lower index; none without a score.
  std::vector<PartnerLists> BestPartners(const std::vector<PairScore>& scores, int count) const;

 private:
  struct Pixel {
    int index;  // row-major
    int facet;
  };
  struct SampledView {
    Camera camera;
    Eigen::Matrix<double, 3, 4> projection;
    Eigen::Vector3d center;
    double focal_px = 0;
    double seen = 0;
    cv::Mat mask;               // empty = none
    int depth_stride = 1;       // pixels between those of the depth map
    cv::Mat1f inverse_depth;    // 0 = nothing
    std::vector<Pixel> pixels;  // of the points, along the curve
  };
  struct Point {
    Eigen::Vector3d position;
    Eigen::Vector3d normal;
    PointSight sight;  // of the view whose point it is
  };

  std::vector<Point> PointsOf(const SampledView& view) const;
  static bool Sees(const SampledView& view, const Point& point);
  // By every `stride`-th point of the view that sees `seen`.
  PairMeasure Estimate(const std::vector<Point>& points, size_t stride, double seen,
                       const SampledView& second) const;

  const TriangleMesh* mesh_;
  std::vector<SampledView> views_;
  ParallaxRange range_;
};

}  // namespace burin
