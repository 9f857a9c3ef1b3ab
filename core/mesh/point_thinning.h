// Points of a surface at one density: scans and samples are dense where the sensor or the sampling
// lingered, and a mean over them would weigh those parts more.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace burin {

// A subset in which no two points are nearer than `spacing` (world units, positive) and every point
// left out is nearer than that to one kept: points are visited in an order drawn from `seed` and
// kept when they can be. Kept points stay in the order given. Points must be finite.
std::vector<Eigen::Vector3d> Thinned(const std::vector<Eigen::Vector3d>& points, double spacing,
                                     std::uint64_t seed);

}  // namespace burin
