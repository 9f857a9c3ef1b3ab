#include "reconstruct/minimum_cut.h"

#ifdef BURIN_WITH_CGAL
#include <maxflow/graph.h>

#include <stdexcept>
#endif

namespace burin {

#ifdef BURIN_WITH_CGAL
namespace {

// Whole numbers in double are exact up to 2^53. The library's graph of int would overflow in its sum of the flow.
using Graph = maxflow::Graph<double, double, double>;

constexpr double kNever = 1e12;  // above every sum of int32 that a cell's four facets can have

void Fail(const char* message) { throw std::runtime_error(message); }

}  // namespace

std::vector<char> MinimumCut(const Tetrahedra& tetrahedra, const CutCosts& costs) {
  const int cells = tetrahedra.CellCount();
  Graph graph(cells, 2 * cells, Fail);
  graph.add_node(cells);
  for (int c = 0; c < cells; ++c) {
    graph.add_tweights(c, costs.must_be_outside[c] != 0 ? kNever : 0, costs.outside[c]);
    for (int k = 0; k < 4; ++k) {
      const int other = tetrahedra.neighbors[c][k];
      if (other < c) continue;
      graph.add_edge(c, other, costs.facet[c][k], costs.facet[other][tetrahedra.FacetTo(other, c)]);
    }
  }
  graph.maxflow();
  std::vector<char> inside(cells);
  for (int c = 0; c < cells; ++c) {
    inside[c] = graph.what_segment(c, Graph::SINK) == Graph::SINK ? 1 : 0;
  }
  return inside;
}

#else

std::vector<char> MinimumCut(const Tetrahedra& /*tetrahedra*/, const CutCosts& /*costs*/) {
  RequireTriangulation();
  return {};
}

#endif

}  // namespace burin
