// Delaunay tetrahedra of points as plain arrays. CGAL makes them, in triangulation.cc and nowhere else: it is under
// the GPL, and the option BURIN_WITH_CGAL of CMake leaves it out.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace burin {

// Cells that fill space: the tetrahedra of the points, and around their hull a cell on each of its facets, with the
// vertex at infinity. Facet k of a cell is the one opposite its corner k.
struct Tetrahedra {
  static constexpr int kInfinite = -1;

  std::vector<std::array<int, 4>> corners;    // indices of points, or kInfinite; Orientation > 0
  std::vector<std::array<int, 4>> neighbors;  // the cell across each facet

  int CellCount() const { return static_cast<int>(corners.size()); }
  bool IsInfinite(int cell) const { return CornerOf(cell, kInfinite) >= 0; }
  // Which corner of the cell is this point; -1 = none.
  int CornerOf(int cell, int point) const { return Find(corners[cell], point); }
  // The facet of `cell` that `neighbor` lies across.
  int FacetTo(int cell, int neighbor) const { return Find(neighbors[cell], neighbor); }
  // Corners of facet k, counter-clockwise seen from the neighbour.
  std::array<int, 3> Facet(int cell, int k) const;

 private:
  static int Find(const std::array<int, 4>& values, int value) {
    for (int k = 0; k < 4; ++k) {
      if (values[k] == value) return k;
    }
    return -1;
  }
};

// Cells around each point in compressed rows.
struct PointCells {
  explicit PointCells(const Tetrahedra& tetrahedra, int point_count);
  const int* Begin(int point) const { return cells.data() + start[point]; }
  const int* End(int point) const { return cells.data() + start[point + 1]; }

  std::vector<int> start;
  std::vector<int> cells;
};

// Throws InputError where fewer than four points, or none off one plane, leave no tetrahedron. A point at the place
// of another is in no cell. The same cells in the same order whenever the points are the same.
Tetrahedra Triangulate(const std::vector<Eigen::Vector3d>& points);

// The sign of det(b - a, c - a, d - a), exact: +1, 0 or -1.
int Orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d);

// Throws InputError where burin was built without CGAL.
void RequireTriangulation();

}  // namespace burin
