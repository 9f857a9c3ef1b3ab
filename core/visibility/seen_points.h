// Surface points that the views see: where cameras are compared (core/scene/camera_similarity.h).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"

namespace burin {

constexpr int kSeenPoints = 1500;

// The points that the camera sees through the centres of pixels of a regular grid, at most `count` of them,
// row by row. The grid has about `count` pixels, all of the image where that has fewer. Left out are pixels that
// the mask leaves out, and those that see nothing, or a facet from behind. What is nearer than near_depth is not
// there. Empty for a camera without pixels.
std::vector<std::vector<Eigen::Vector3d>> SeenPoints(const TriangleMesh& mesh,
                                                     const std::vector<View>& views,
                                                     int count = kSeenPoints);

}  // namespace burin
