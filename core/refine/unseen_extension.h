// Carries what no pair has ever seen along with its surroundings.
//
// Unseen vertices do not take part in a solve. Afterwards each is displaced by the mean displacement of
// its neighbours, all at once: the harmonic extension of the displacements around. It keeps the shape
// of what is not seen, and by the maximum principle moves nothing further than the vertices around
// the hole moved. (Left to the smoothness term in the solve, which squares Laplacians, the extension would
// continue the slope at the rim instead: backs of bodies drift by tens of pixels.)
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/solve/energy_term.h"

namespace burin {

// `before` are the positions before the solve. Moves the vertices that context.was_supported has
// zero and that hang together with one that has not; parts that do not stay where they are. Returns
// the number of vertices moved.
int ExtendToUnseen(const RoundContext& context, const std::vector<Eigen::Vector3d>& before,
                   TriangleMesh* mesh);

}  // namespace burin
