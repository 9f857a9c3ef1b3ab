// Coordinates far from the origin in single precision: whether its steps there are visible in the photographs.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"

namespace burin {

// "at 5.41e+06 single precision has steps of 0.5 units, 55 px" when these are above a tenth of a pixel, else nothing: the
// step of a float at the largest coordinate of the points that views see, over the median of their pixels' footprints.
std::string SinglePrecisionSteps(const Scene& scene, const std::vector<Eigen::Vector3d>& points);

// The same about the mesh, where all its coordinates are single precision; as a line for the user.
std::string MeshPrecisionLine(const Scene& scene, const TriangleMesh& mesh);

// A line that names the part of the mesh that is farthest from what the views see, where that is more than a thousand times
// its size away; else nothing.
std::string StrayPartLine(const Scene& scene, const TriangleMesh& mesh);

}  // namespace burin
