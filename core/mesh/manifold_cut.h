// Where any set of triangles must be cut open to be a mesh that a half-edge structure can hold.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

inline bool RepeatsVertex(const Eigen::Vector3i& face) {
  return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

// Corner 3f+c is corner c of face f. Corners of one vertex get the same label when a walk over
// faces around it, across edges of exactly two faces that go opposite ways, leads from one to the
// other. One vertex per label is a mesh that a half-edge structure holds: it is cut open along
// non-manifold edges and at vertices where fans touch, and nowhere else.
// Faces that repeat a vertex take no part.
std::vector<int> LabelCorners(const TriangleMesh& mesh);

}  // namespace burin
