// Cuts polygons into triangles.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace burin {

// Triangles of the polygon with these corners, in its own direction, as indices into `corners`: two fewer than corners. A
// convex polygon becomes the fan around its first corner. From another one ears are cut, in its projection along the
// normal of its area, so that their areas add up to the polygon's and none is turned over; one that crosses itself ends as
// the fan of what is left.
std::vector<Eigen::Vector3i> CutPolygon(const std::vector<Eigen::Vector3d>& corners);

}  // namespace burin
