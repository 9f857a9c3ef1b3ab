#include "reconstruct/triangulation.h"

#include <utility>

#include "core/support/error.h"

#ifdef BURIN_WITH_CGAL
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#endif

namespace burin {

std::array<int, 3> Tetrahedra::Facet(int cell, int k) const {
  const std::array<int, 4>& c = corners[cell];
  std::array<int, 3> facet = {c[(k + 1) & 3], c[(k + 2) & 3], c[(k + 3) & 3]};
  if ((k & 1) != 0) std::swap(facet[1], facet[2]);
  return facet;
}

PointCells::PointCells(const Tetrahedra& tetrahedra, int point_count)
    : start(static_cast<size_t>(point_count) + 1, 0) {
  for (const std::array<int, 4>& corners : tetrahedra.corners) {
    for (const int point : corners) {
      if (point >= 0) ++start[point + 1];
    }
  }
  for (int p = 0; p < point_count; ++p) start[p + 1] += start[p];
  cells.resize(start.back());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (int c = 0; c < tetrahedra.CellCount(); ++c) {
    for (const int point : tetrahedra.corners[c]) {
      if (point >= 0) cells[next[point]++] = c;
    }
  }
}

#ifdef BURIN_WITH_CGAL
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<int, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<int, Kernel>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<Kernel,
                                   CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

Kernel::Point_3 ToCgal(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

Tetrahedra Triangulate(const std::vector<Eigen::Vector3d>& points) {
  std::vector<std::pair<Kernel::Point_3, int>> numbered;
  numbered.reserve(points.size());
  for (size_t p = 0; p < points.size(); ++p) {
    numbered.emplace_back(ToCgal(points[p]), static_cast<int>(p));
  }
  Delaunay delaunay(numbered.begin(), numbered.end());
  if (delaunay.dimension() < 3) {
    throw InputError("a surface needs at least four points that are not in one plane; there are " +
                     std::to_string(points.size()) + " points");
  }
  delaunay.infinite_vertex()->info() = Tetrahedra::kInfinite;
  Tetrahedra tetrahedra;
  int count = 0;
  for (auto cell = delaunay.all_cells_begin(); cell != delaunay.all_cells_end(); ++cell) {
    cell->info() = count++;
  }
  tetrahedra.corners.resize(count);
  tetrahedra.neighbors.resize(count);
  for (auto cell = delaunay.all_cells_begin(); cell != delaunay.all_cells_end(); ++cell) {
    for (int k = 0; k < 4; ++k) {
      tetrahedra.corners[cell->info()][k] = cell->vertex(k)->info();
      tetrahedra.neighbors[cell->info()][k] = cell->neighbor(k)->info();
    }
  }
  return tetrahedra;
}

int Orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d) {
  return CGAL::orientation(ToCgal(a), ToCgal(b), ToCgal(c), ToCgal(d));
}

void RequireTriangulation() {}

#else

void RequireTriangulation() {
  throw InputError(
      "this burin was built without CGAL (BURIN_WITH_CGAL of CMake) and makes no surface of "
      "points");
}

Tetrahedra Triangulate(const std::vector<Eigen::Vector3d>& /*points*/) {
  RequireTriangulation();
  return {};
}

int Orientation(const Eigen::Vector3d& /*a*/, const Eigen::Vector3d& /*b*/,
                const Eigen::Vector3d& /*c*/, const Eigen::Vector3d& /*d*/) {
  RequireTriangulation();
  return 0;
}

#endif

}  // namespace burin
