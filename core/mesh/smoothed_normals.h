// Normals of a mesh that is rougher than the surface it stands for.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// VertexNormals, each then `rounds` times made the mean of itself and its neighbours', of unit length; a mean that is
// shorter than 0.3, as on tiny bodies, says nothing and is not taken. Arguments as VertexNormals and VertexNeighbors
// make them.
std::vector<Eigen::Vector3d> SmoothedNormals(const TriangleMesh& mesh, const Adjacency& faces,
                                             const Adjacency& neighbors, int rounds);

}  // namespace burin
