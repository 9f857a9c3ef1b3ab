// Carries what a round has no evidence for along with its surroundings.
//
// Vertices that took no part in a solve are displaced afterwards by the mean displacement of their
// neighbours, all at once: the harmonic extension (a membrane) of the displacements around. It keeps the
// shape of what is not known, and by the maximum principle moves nothing further than the vertices around
// the hole moved. (Left to the smoothness term in the solve, which squares Laplacians, the extension would
// continue the slope at the rim instead: backs of bodies drift by tens of pixels.)
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// `before` are the positions before the solve. Moves the vertices that `placed` has zero and that hang
// together with one that is placed; parts that do not stay where they are. Returns the number of vertices
// moved.
int CarryAlong(const Adjacency& neighbors, const std::vector<char>& placed,
               const std::vector<Eigen::Vector3d>& before, TriangleMesh* mesh);

}  // namespace burin
