// An order of a mesh's vertices and facets in which neighbours in space are neighbours in memory.
// Subdivision appends vertices as it makes them; without this every facet, patch and row of the
// normal equations gathers from all over memory.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

struct MeshOrder {
  std::vector<int> vertex;  // vertex k of the ordered mesh is vertex[k] of the given one
  std::vector<int> face;
};

// Facets along a Morton curve through their centroids (ties: by index), vertices in the order in
// which the facets first use them, unused ones last.
MeshOrder OrderAlongCurve(const TriangleMesh& mesh);

TriangleMesh Ordered(const TriangleMesh& mesh, const MeshOrder& order);

// Copies the vertex positions of Ordered(mesh, order) back to `mesh`.
void RestoreVertices(const TriangleMesh& ordered, const MeshOrder& order, TriangleMesh* mesh);

}  // namespace burin
