#include "core/visibility/facet_map.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 4096;
constexpr size_t kMaxFacets = size_t{1} << 29;  // whose codes are ints
constexpr int kBands = 16;                      // of rows, drawn side by side
constexpr double kBoundsPx = 1e-6;              // more than projected corners are off by
constexpr int kWideFacet = 8;        // columns from which on a row's ends are worth computing
constexpr double kRowEndsPx = 1e-3;  // what they may be off by

// Pixels that may be on a facet; none when empty.
struct Bounds {
  int first_column = 0;
  int end_column = 0;
  int first_row = 0;
  int end_row = 0;
};

// Centres within [low, high], of `count` pixels.
void PixelsBetween(double low, double high, int count, int* first, int* end) {
  const double bound = count;
  *first = static_cast<int>(std::clamp(std::ceil(low - kBoundsPx - 0.5), 0.0, bound));
  *end = static_cast<int>(std::clamp(std::floor(high + kBoundsPx - 0.5) + 1, 0.0, bound));
}

class FacetDrawing {
 public:
  FacetDrawing(const TriangleMesh& mesh, const Camera& camera)
      : mesh_(mesh), camera_(camera), corners_(mesh.vertices.size()), bounds_(mesh.faces.size()) {
    const Eigen::Matrix<double, 3, 4> projection = camera.ProjectionMatrix();
    ParallelFor(static_cast<int>(corners_.size()), kVertexGrain, [&](int begin, int end) {
      for (int v = begin; v < end; ++v) {
        corners_[v] = projection.leftCols<3>() * mesh.vertices[v] + projection.col(3);
      }
    });
    ParallelFor(static_cast<int>(bounds_.size()), kVertexGrain, [&](int begin, int end) {
      for (int f = begin; f < end; ++f) bounds_[f] = BoundsOf(mesh.faces[f]);
    });
  }

  // Rows [begin, end).
  void Draw(int begin, int end, cv::Mat1i* map, cv::Mat1f* nearest) const {
    for (size_t f = 0; f < bounds_.size(); ++f) {
      const Bounds& bounds = bounds_[f];
      if (bounds.first_row >= end || bounds.end_row <= begin) continue;
      DrawFacet(static_cast<int>(f), std::max(bounds.first_row, begin),
                std::min(bounds.end_row, end), map, nearest);
    }
  }

 private:
  Bounds BoundsOf(const Eigen::Vector3i& face) const {
    Bounds bounds;
    int before = 0;  // the camera
    int beyond = 0;  // its near depth
    double low_x = std::numeric_limits<double>::infinity();
    double low_y = low_x;
    double high_x = -low_x;
    double high_y = -low_x;
    for (const int v : face) {
      const Eigen::Vector3d& corner = corners_[v];
      if (!corner.allFinite()) return bounds;
      if (corner.z() > camera_.near_depth) ++beyond;
      if (!(corner.z() > 0)) continue;
      ++before;
      const double x = corner.x() / corner.z();
      const double y = corner.y() / corner.z();
      low_x = std::min(low_x, x);
      low_y = std::min(low_y, y);
      high_x = std::max(high_x, x);
      high_y = std::max(high_y, y);
    }
    if (beyond == 0) return bounds;
    if (before < 3) return {0, camera_.width, 0, camera_.height};
    PixelsBetween(low_x, high_x, camera_.width, &bounds.first_column, &bounds.end_column);
    PixelsBetween(low_y, high_y, camera_.height, &bounds.first_row, &bounds.end_row);
    if (bounds.first_column >= bounds.end_column) bounds.end_row = bounds.first_row;
    return bounds;
  }

  void DrawFacet(int f, int begin, int end, cv::Mat1i* map, cv::Mat1f* nearest) const {
    const Eigen::Vector3i& face = mesh_.faces[f];
    // By corner: |det| u_k is `edge` . (x, y, 1). From the corner of lower index to the other and then turned, so that the two
    // facets of an edge compute the same number.
    std::array<Eigen::Vector3d, 3> edge;
    std::array<bool, 3> has_edge;  // pixels where it is zero are of this facet
    const double det = corners_[face[0]].dot(corners_[face[1]].cross(corners_[face[2]]));
    if (!std::isfinite(det) || det == 0) return;
    for (int k = 0; k < 3; ++k) {
      const int a = face[(k + 1) % 3];
      const int b = face[(k + 2) % 3];
      const Eigen::Vector3d canonical = corners_[std::min(a, b)].cross(corners_[std::max(a, b)]);
      has_edge[k] = (a < b) == (det > 0);
      edge[k] = has_edge[k] ? canonical : -canonical;
    }
    const Eigen::Vector3d depth = (edge[0] + edge[1] + edge[2]) / std::abs(det);  // its inverse
    const double nearer_than_seen =
        camera_.near_depth > 0 ? 1 / camera_.near_depth : std::numeric_limits<double>::infinity();
    const Bounds& bounds = bounds_[f];
    for (int row = begin; row < end; ++row) {
      const double y = row + 0.5;
      std::array<double, 3> at;
      for (int k = 0; k < 3; ++k) at[k] = edge[k].y() * y + edge[k].z();
      int first = bounds.first_column;
      int last = bounds.end_column;
      if (last - first > kWideFacet) RowEnds(edge, at, &first, &last);
      const double depth_at = depth.y() * y + depth.z();
      float* nearest_row = (*nearest)[row];
      int* map_row = (*map)[row];
      for (int column = first; column < last; ++column) {
        const double x = column + 0.5;
        const double u0 = edge[0].x() * x + at[0];
        const double u1 = edge[1].x() * x + at[1];
        const double u2 = edge[2].x() * x + at[2];
        if (u0 < 0 || u1 < 0 || u2 < 0) continue;
        if ((u0 == 0 && !has_edge[0]) || (u1 == 0 && !has_edge[1]) || (u2 == 0 && !has_edge[2])) {
          continue;
        }
        const double inverse = depth.x() * x + depth_at;
        const auto rounded = static_cast<float>(inverse);
        if (!(rounded > nearest_row[column]) || inverse >= nearer_than_seen) continue;
        nearest_row[column] = rounded;
        const int corner = u0 >= u1 ? (u0 >= u2 ? 0 : 2) : (u1 >= u2 ? 1 : 2);
        map_row[column] = FacetCorner{f, corner}.Code();
      }
    }
  }

  // Narrows [first, end) to columns that no edge rules out.
  static void RowEnds(const std::array<Eigen::Vector3d, 3>& edge, const std::array<double, 3>& at,
                      int* first, int* end) {
    double low = *first;
    double high = *end;
    for (int k = 0; k < 3; ++k) {
      const double slope = edge[k].x();
      if (slope == 0) {
        if (at[k] < 0) high = low;
        continue;
      }
      const double zero = -at[k] / slope - 0.5;
      if (slope > 0) {
        low = std::max(low, std::floor(zero - kRowEndsPx));
      } else {
        high = std::min(high, std::ceil(zero + kRowEndsPx) + 1);
      }
    }
    if (!(high > low)) {
      *end = *first;
      return;
    }
    *first = static_cast<int>(low);
    *end = static_cast<int>(high);
  }

  const TriangleMesh& mesh_;
  const Camera& camera_;
  std::vector<Eigen::Vector3d> corners_;  // h, by vertex
  std::vector<Bounds> bounds_;            // by facet
};

}  // namespace

CornerMap::CornerMap(const TriangleMesh& mesh, const Camera& camera)
    : codes(camera.height, camera.width, -1), inverse_depth(camera.height, camera.width, 0.0F) {
  CHECK_LT(mesh.faces.size(), kMaxFacets);
  const FacetDrawing drawing(mesh, camera);
  const int rows = (camera.height + kBands - 1) / kBands;
  ParallelFor(kBands, 1, [&](int begin, int end) {
    for (int band = begin; band < end; ++band) {
      drawing.Draw(std::min(band * rows, camera.height), std::min((band + 1) * rows, camera.height),
                   &codes, &inverse_depth);
    }
  });
}

cv::Mat1i FacetMap(const TriangleMesh& mesh, const Camera& camera) {
  cv::Mat1i map = CornerMap(mesh, camera).codes;
  for (int& code : map) {
    if (code >= 0) code = FacetCorner::Of(code).facet;
  }
  return map;
}

}  // namespace burin
