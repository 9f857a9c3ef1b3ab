#include "core/visibility/facet_map.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/support/parallel.h"
#include "core/visibility/facet_rows.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 4096;
constexpr size_t kMaxFacets = size_t{1} << 29;  // whose codes are ints
constexpr int kRowGrain = 64;
constexpr int kBands = 8;           // of rows, drawn side by side
constexpr double kBoundsPx = 1e-6;  // more than projected corners are off by
// Of an edge whose pixels are of the other facet, and of one whose are of this.
constexpr double kSign[2] = {-1, 1};
constexpr double kLeast[2] = {std::numeric_limits<double>::denorm_min(), 0};

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
  void Draw(int begin, int end, CornerMap* map) const {
    for (size_t f = 0; f < bounds_.size(); ++f) {
      const Bounds& bounds = bounds_[f];
      if (bounds.first_row >= end || bounds.end_row <= begin) continue;
      DrawFacet(static_cast<int>(f), std::max(bounds.first_row, begin),
                std::min(bounds.end_row, end), map);
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

  void DrawFacet(int f, int begin, int end, CornerMap* map) const {
    const Eigen::Vector3i& face = mesh_.faces[f];
    const double det = corners_[face[0]].dot(corners_[face[1]].cross(corners_[face[2]]));
    if (!std::isfinite(det) || det == 0) return;
    FacetRows rows;
    // By corner: |det| u_k is `edge` . (x, y, 1). From the corner of lower index to the other and then turned, so that the two
    // facets of an edge compute the same number.
    Eigen::Vector3d sum(0, 0, 0);
    for (int k = 0; k < 3; ++k) {
      const int a = face[(k + 1) % 3];
      const int b = face[(k + 2) % 3];
      const bool has_edge = (a < b) == (det > 0);  // pixels where it is zero are of this facet
      const Eigen::Vector3d edge =
          kSign[has_edge ? 1 : 0] * corners_[std::min(a, b)].cross(corners_[std::max(a, b)]);
      rows.edge_x[k] = edge.x();
      rows.edge_y[k] = edge.y();
      rows.edge_1[k] = edge.z();
      rows.least[k] = kLeast[has_edge ? 1 : 0];
      sum += edge;
    }
    const Eigen::Vector3d depth = sum / std::abs(det);  // its inverse
    for (int k = 0; k < 3; ++k) rows.depth[k] = depth[k];
    rows.too_near =
        camera_.near_depth > 0 ? 1 / camera_.near_depth : std::numeric_limits<double>::infinity();
    rows.first_column = bounds_[f].first_column;
    rows.end_column = bounds_[f].end_column;
    rows.first_row = begin;
    rows.end_row = end;
    rows.code = FacetCorner{f, 0}.Code();
    DrawFacetRows(rows, map->pixels.data(), map->stride);
  }

  const TriangleMesh& mesh_;
  const Camera& camera_;
  std::vector<Eigen::Vector3d> corners_;  // h, by vertex
  std::vector<Bounds> bounds_;            // by facet
};

}  // namespace

CornerMap::CornerMap(const TriangleMesh& mesh, const Camera& camera)
    : width(camera.width),
      height(camera.height),
      stride(static_cast<size_t>(camera.width) + kRowPadding),
      pixels(stride * camera.height, 0) {
  CHECK_LT(mesh.faces.size(), kMaxFacets);
  const FacetDrawing drawing(mesh, camera);
  const int rows = (height + kBands - 1) / kBands;
  ParallelFor(kBands, 1, [&](int begin, int end) {
    for (int band = begin; band < end; ++band) {
      drawing.Draw(std::min(band * rows, height), std::min((band + 1) * rows, height), this);
    }
  });
}

cv::Mat1i FacetMap(const TriangleMesh& mesh, const Camera& camera, cv::Mat1f* inverse_depth) {
  const CornerMap corners(mesh, camera);
  cv::Mat1i map(camera.height, camera.width);
  if (inverse_depth != nullptr) inverse_depth->create(camera.height, camera.width);
  ParallelFor(camera.height, kRowGrain, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const int code = corners.CodeAt(x, y);
        map(y, x) = code < 0 ? -1 : FacetCorner::Of(code).facet;
        if (inverse_depth != nullptr) (*inverse_depth)(y, x) = corners.InverseDepthAt(x, y);
      }
    }
  });
  return map;
}

}  // namespace burin
