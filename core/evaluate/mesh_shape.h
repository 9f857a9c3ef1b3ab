// How well shaped the triangles of a mesh are: what a score of its surface does not see.
#pragma once

#include "core/mesh/mesh.h"

namespace burin {

struct MeshShape {
  double quality = 0;       // mean of FacetQuality (core/mesh/facet_quality.h)
  double under_10_deg = 0;  // share of the facets with an angle below it
  double over_150_deg = 0;  // and above it
};

// Of a mesh without facets all are 0. A facet without area has quality 0 and is in both shares.
MeshShape ShapeOf(const TriangleMesh& mesh);

}  // namespace burin
