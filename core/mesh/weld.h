// Joins what a file keeps apart: exporters write a vertex once for each texture coordinate or normal, STL once for each
// facet. Vertices at one position that are two for no geometrical reason would move apart in a refinement.
#pragma once

#include "core/mesh/mesh.h"

namespace burin {

// Takes out the faces whose three vertices an earlier face has, either way round, and those whose three positions an
// earlier one has in the same direction; returns how many.
int DropDuplicateFaces(TriangleMesh* mesh);

// Where two border edges run between the same two positions, bit for bit, and no third face has an edge there, their ends
// become one vertex each, the one of lower index. What would make an edge of more than two faces stays as it is, and so do
// vertices that only touch. Vertices that no face uses any more are taken out, the others keep their order. Returns how
// many vertices went.
int WeldSeams(TriangleMesh* mesh);

}  // namespace burin
