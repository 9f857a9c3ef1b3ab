// The surface between the cells inside and outside of a cut, as a mesh that a half-edge structure holds.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "reconstruct/sighted_points.h"
#include "reconstruct/triangulation.h"

namespace burin {

struct CutSurfaceRules {
  double max_edge_footprints = 0;  // of the smallest footprint among the facet's corners
  int min_part_facets = 1;         // parts hang together across edges
};

struct CutSurface {
  TriangleMesh mesh;  // counter-clockwise seen from outside, each vertex one fan of facets
  std::vector<int>
      points;  // the point that each vertex is; a point that fans touch at has several vertices
  int long_facets = 0;  // dropped
  int small_parts = 0;  // dropped
  int small_part_facets = 0;
};

// Facets that meet at an edge are paired as the inside goes around it: where more than two meet, each pair bounds one
// wedge of the inside.
CutSurface SurfaceOfCut(const SightedPoints& points, const Tetrahedra& tetrahedra,
                        const std::vector<char>& inside, const CutSurfaceRules& rules);

}  // namespace burin
