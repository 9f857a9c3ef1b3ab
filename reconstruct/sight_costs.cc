#include "reconstruct/sight_costs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/support/median.h"
#include "core/support/parallel.h"
#include "reconstruct/sight_walk.h"

namespace burin {
namespace {

constexpr double kUnit = 256;  // of whole numbers, for a cost of 1
constexpr double kBehindSigmas = 3;
constexpr int kPointsPerItem = 512;
constexpr int kCellsPerItem = 4096;

// Lines of sight from several threads meet in a cell; sums of whole numbers do not depend on the order.
void AddTo(std::int32_t* sum, double cost) {
  __atomic_fetch_add(sum, static_cast<std::int32_t>(kUnit * cost), __ATOMIC_RELAXED);
}

// Cosine of the angle between facet k and the sphere around the cell.
std::array<float, 4> SphereCosines(const std::vector<Eigen::Vector3d>& points,
                                   const Tetrahedra& tetrahedra, int cell) {
  const std::array<int, 4>& corners = tetrahedra.corners[cell];
  const Eigen::Vector3d& a = points[corners[0]];
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.row(k) = points[corners[k + 1]] - a;
  // The centre c is as far from each corner as from a: edge . (c - a) = |edge|^2 / 2.
  const Eigen::Vector3d center =
      edges.fullPivLu().solve(edges.rowwise().squaredNorm() / 2).eval() + a;
  const double radius = (center - a).norm();
  std::array<float, 4> cosines;
  for (int k = 0; k < 4; ++k) {
    const std::array<int, 3> facet = tetrahedra.Facet(cell, k);
    const Eigen::Vector3d& p = points[facet[0]];
    const Eigen::Vector3d outward = (points[facet[1]] - p).cross(points[facet[2]] - p).normalized();
    const double cosine = radius > 0 ? outward.dot(p - center) / radius : 1;
    cosines[k] = static_cast<float>(std::isfinite(cosine) ? std::clamp(cosine, -1.0, 1.0) : 1);
  }
  return cosines;
}

void AddQuality(const std::vector<Eigen::Vector3d>& points, const Tetrahedra& tetrahedra,
                double quality, CutCosts* costs) {
  const int cells = tetrahedra.CellCount();
  std::vector<std::array<float, 4>> cosines(cells, {1, 1, 1, 1});
  ParallelFor(cells, kCellsPerItem, [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      if (!tetrahedra.IsInfinite(c)) cosines[c] = SphereCosines(points, tetrahedra, c);
    }
  });
  ParallelFor(cells, kCellsPerItem, [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      for (int k = 0; k < 4; ++k) {
        const int other = tetrahedra.neighbors[c][k];
        const float least = std::min(cosines[c][k], cosines[other][tetrahedra.FacetTo(other, c)]);
        costs->facet[c][k] += static_cast<std::int32_t>(quality * kUnit * (1 - least));
      }
    }
  });
}

// A camera off the hull is in the infinite cell of every facet of the hull that it sees.
void PutOutsideWhatCamerasSeeOfTheHull(const SightedPoints& points, const Tetrahedra& tetrahedra,
                                       const std::vector<Eigen::Vector3d>& centers,
                                       CutCosts* costs) {
  std::vector<int> used = points.views;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (int c = 0; c < tetrahedra.CellCount(); ++c) {
    const int infinite = tetrahedra.CornerOf(c, Tetrahedra::kInfinite);
    if (infinite < 0) continue;
    const std::array<int, 3> f = tetrahedra.Facet(c, infinite);  // from within the hull
    const bool seen = std::any_of(used.begin(), used.end(), [&](int v) {
      return Orientation(points.positions[f[0]], points.positions[f[1]], points.positions[f[2]],
                         centers[v]) < 0;
    });
    if (seen) costs->must_be_outside[c] = 1;
  }
}

}  // namespace

double PointSpacing(const std::vector<Eigen::Vector3d>& points, const Tetrahedra& tetrahedra) {
  const PointCells around(tetrahedra, static_cast<int>(points.size()));
  std::vector<double> spacings(points.size(), 0);
  ParallelFor(static_cast<int>(points.size()), kPointsPerItem, [&](int begin, int end) {
    std::vector<int> neighbors;
    std::vector<double> lengths;
    for (int p = begin; p < end; ++p) {
      neighbors.clear();
      for (const int* c = around.Begin(p); c != around.End(p); ++c) {
        for (const int other : tetrahedra.corners[*c]) {
          if (other >= 0 && other != p) neighbors.push_back(other);
        }
      }
      std::sort(neighbors.begin(), neighbors.end());
      neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
      lengths.clear();
      for (const int other : neighbors) lengths.push_back((points[other] - points[p]).norm());
      if (lengths.empty()) continue;
      const auto quartile = lengths.begin() + static_cast<long>(lengths.size() / 4);
      std::nth_element(lengths.begin(), quartile, lengths.end());
      spacings[p] = *quartile;
    }
  });
  spacings.erase(std::remove(spacings.begin(), spacings.end(), 0.0), spacings.end());
  return Median(std::move(spacings));
}

SightCosts CostsOfSights(const SightedPoints& points, const Tetrahedra& tetrahedra,
                         const std::vector<Eigen::Vector3d>& centers, double sigma,
                         double quality) {
  SightCosts result{CutCosts(tetrahedra.CellCount())};
  CutCosts& costs = result.costs;
  const SightWalk walk(points.positions, tetrahedra);
  std::atomic<long> lost = 0;
  ParallelFor(points.Count(), kPointsPerItem, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      for (int s = points.begin[p]; s < points.begin[p + 1]; ++s) {
        const Eigen::Vector3d& center = centers[points.views[s]];
        const Eigen::Vector3d toward = (center - points.positions[p]).normalized();
        const auto cost = [&](const Eigen::Vector3d& direction, int cell, int k) {
          const double d = walk.DistanceToFacet(p, direction, cell, k);
          return 1 - std::exp(-d * d / (2 * sigma * sigma));
        };
        const int camera_cell = walk.Walk(p, center, [&](int cell, int k) {
          const int other = tetrahedra.neighbors[cell][k];
          AddTo(&costs.facet[other][tetrahedra.FacetTo(other, cell)], cost(toward, cell, k));
        });
        if (camera_cell >= 0) {
          __atomic_store_n(&costs.must_be_outside[camera_cell], 1, __ATOMIC_RELAXED);
        } else {
          ++lost;
        }
        const int behind = walk.Walk(
            p, points.positions[p] - kBehindSigmas * sigma * toward,
            [&](int cell, int k) { AddTo(&costs.facet[cell][k], cost(-toward, cell, k)); });
        if (behind >= 0) {
          AddTo(&costs.outside[behind], 1);
        } else {
          ++lost;
        }
      }
    }
  });
  PutOutsideWhatCamerasSeeOfTheHull(points, tetrahedra, centers, &costs);
  if (quality > 0) AddQuality(points.positions, tetrahedra, quality, &costs);
  result.lines = static_cast<long>(points.views.size());
  result.lost = lost;
  return result;
}

}  // namespace burin
