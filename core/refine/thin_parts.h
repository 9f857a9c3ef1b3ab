// Which vertices lie on parts of the surface that are thinner than a correlation window.
//
// The thickness at a vertex is the way from it along its inward normal to where that ray leaves the mesh.
// On such a part few windows or none lie wholly on the surface, and what smoothness does to it, drawing it
// together as 1/radius, the photographs do not hold against.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// 1 for every vertex whose thickness is below `width`, in the mesh's unit; 0 where the ray leaves the mesh
// through nothing or through the front of a facet (open and folded surfaces have no inside there), and
// where the normal is zero.
std::vector<char> ThinVertices(const TriangleMesh& mesh,
                               const std::vector<Eigen::Vector3d>& normals, double width);
// The same, each vertex with a width of its own.
std::vector<char> ThinVertices(const TriangleMesh& mesh,
                               const std::vector<Eigen::Vector3d>& normals,
                               const std::vector<double>& width);

}  // namespace burin
