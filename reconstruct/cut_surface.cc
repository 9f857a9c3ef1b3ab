#include "reconstruct/cut_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/mesh/manifold_cut.h"
#include "core/support/union_find.h"

namespace burin {
namespace {

struct Facet {
  int cell;  // inside
  int k;     // the facet of the cell
  std::array<int, 3> corners;
};

class Surface {
 public:
  Surface(const Tetrahedra& tetrahedra, const std::vector<char>& inside)
      : tetrahedra_(tetrahedra), inside_(inside) {
    number_.assign(tetrahedra.CellCount(), {-1, -1, -1, -1});
    for (int c = 0; c < tetrahedra.CellCount(); ++c) {
      if (inside[c] == 0) continue;
      for (int k = 0; k < 4; ++k) {
        const std::array<int, 3> corners = tetrahedra.Facet(c, k);
        const bool finite = *std::min_element(corners.begin(), corners.end()) >= 0;
        if (inside[tetrahedra.neighbors[c][k]] != 0 || !finite) continue;
        number_[c][k] = static_cast<int>(facets_.size());
        facets_.push_back({c, k, corners});
      }
    }
  }

  const std::vector<Facet>& facets() const { return facets_; }

  // The facet across the edge from corner j of facet f to the next: around the edge, through inside cells. -1 where
  // that one has the vertex at infinity.
  int Across(int f, int j) const {
    const int a = facets_[f].corners[j];
    const int b = facets_[f].corners[(j + 1) % 3];
    int cell = facets_[f].cell;
    int through = tetrahedra_.CornerOf(cell, facets_[f].corners[(j + 2) % 3]);
    for (;;) {
      const int next = tetrahedra_.neighbors[cell][through];
      if (inside_[next] == 0) return number_[cell][through];
      const int entry = tetrahedra_.FacetTo(next, cell);
      through = 6 - entry - tetrahedra_.CornerOf(next, a) - tetrahedra_.CornerOf(next, b);
      cell = next;
    }
  }

  int CornerOf(int f, int point) const {
    const std::array<int, 3>& corners = facets_[f].corners;
    return 3 * f +
           static_cast<int>(std::find(corners.begin(), corners.end(), point) - corners.begin());
  }

 private:
  const Tetrahedra& tetrahedra_;
  const std::vector<char>& inside_;
  std::vector<Facet> facets_;
  std::vector<std::array<int, 4>> number_;  // of each cell's facets, in facets_; -1 = none
};

double LongestEdgeFootprints(const SightedPoints& points, const std::array<int, 3>& corners) {
  double longest = 0;
  double footprint = points.footprints[corners[0]];
  for (int j = 0; j < 3; ++j) {
    const int a = corners[j];
    longest =
        std::max(longest, (points.positions[a] - points.positions[corners[(j + 1) % 3]]).norm());
    footprint = std::min(footprint, points.footprints[a]);
  }
  return longest / footprint;
}

// Two wedges of the inside that meet at an edge, and whose facets hang together around both of its ends, share all of it:
// there the mesh is cut open.
void CutOpen(CutSurface* surface) {
  const std::vector<int> labels = LabelCorners(surface->mesh);
  std::vector<int> number(labels.size(), -1);
  TriangleMesh open;
  std::vector<int> points;
  for (size_t f = 0; f < surface->mesh.faces.size(); ++f) {
    Eigen::Vector3i face;
    for (int j = 0; j < 3; ++j) {
      int& vertex = number[labels[3 * f + j]];
      if (vertex < 0) {
        vertex = static_cast<int>(open.vertices.size());
        open.vertices.push_back(surface->mesh.vertices[surface->mesh.faces[f][j]]);
        points.push_back(surface->points[surface->mesh.faces[f][j]]);
      }
      face[j] = vertex;
    }
    open.faces.push_back(face);
  }
  surface->mesh = std::move(open);
  surface->points = std::move(points);
}

}  // namespace

CutSurface SurfaceOfCut(const SightedPoints& points, const Tetrahedra& tetrahedra,
                        const std::vector<char>& inside, const CutSurfaceRules& rules) {
  const Surface surface(tetrahedra, inside);
  const int count = static_cast<int>(surface.facets().size());
  CutSurface result;
  std::vector<char> keep(count);
  for (int f = 0; f < count; ++f) {
    keep[f] =
        LongestEdgeFootprints(points, surface.facets()[f].corners) <= rules.max_edge_footprints ? 1
                                                                                                : 0;
    result.long_facets += keep[f] == 0 ? 1 : 0;
  }
  // Corners of a vertex and facets of a part are joined across edges of kept facets only.
  std::vector<int> vertex_of(3 * static_cast<size_t>(count));
  std::vector<int> part_of(count);
  std::iota(vertex_of.begin(), vertex_of.end(), 0);
  std::iota(part_of.begin(), part_of.end(), 0);
  for (int f = 0; f < count; ++f) {
    if (keep[f] == 0) continue;
    for (int j = 0; j < 3; ++j) {
      const int other = surface.Across(f, j);
      if (other < 0 || keep[other] == 0) continue;
      part_of[FindRoot(&part_of, f)] = FindRoot(&part_of, other);
      for (const int corner : {j, (j + 1) % 3}) {
        const int there = surface.CornerOf(other, surface.facets()[f].corners[corner]);
        vertex_of[FindRoot(&vertex_of, 3 * f + corner)] = FindRoot(&vertex_of, there);
      }
    }
  }
  std::vector<int> part_size(count, 0);
  for (int f = 0; f < count; ++f) part_size[FindRoot(&part_of, f)] += keep[f];
  for (const int size : part_size) {
    result.small_parts += size > 0 && size < rules.min_part_facets ? 1 : 0;
  }
  std::vector<int> vertex_number(vertex_of.size(), -1);
  for (int f = 0; f < count; ++f) {
    if (keep[f] == 0) continue;
    if (part_size[FindRoot(&part_of, f)] < rules.min_part_facets) {
      ++result.small_part_facets;
      continue;
    }
    Eigen::Vector3i face;
    for (int j = 0; j < 3; ++j) {
      int& number = vertex_number[FindRoot(&vertex_of, 3 * f + j)];
      if (number < 0) {
        number = static_cast<int>(result.mesh.vertices.size());
        const int point = surface.facets()[f].corners[j];
        result.mesh.vertices.push_back(points.positions[point]);
        result.points.push_back(point);
      }
      face[j] = number;
    }
    result.mesh.faces.push_back(face);
  }
  CutOpen(&result);
  return result;
}

}  // namespace burin
