// A part of a mesh as a mesh.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// The facets of `mesh` that are not cut (0), with the vertices that they have, both in their order. `vertices` gets
// which those are.
TriangleMesh WithoutFacets(const TriangleMesh& mesh, const std::vector<char>& cut,
                           std::vector<int>* vertices);

}  // namespace burin
