// Pictures of a selection of camera pairs, for people: who is paired with whom, how well the mesh is
// covered, and what the energies of all pairs look like.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

// The mesh and the cameras seen from above ("up" is the mean upward direction of the images), an
// arrow from each reference view to each of its partners, and the number of the view beside its
// camera. The short line of a camera is where it looks.
cv::Mat3b PairGraphPicture(const Scene& scene, const TriangleMesh& mesh,
                           const std::vector<CameraPair>& pairs);

// V_f before (left) and after (right) Algorithm 1 in colours, from up to three views far apart, a
// row each. `before` and `after` hold a count per facet.
cv::Mat3b CoveragePicture(const Scene& scene, const TriangleMesh& mesh,
                          const std::vector<int>& before, const std::vector<int>& after);

// energies[i * views + j] as colours, row i = reference; a pair that is no candidate is white, a
// selected one framed.
cv::Mat3b EnergyMatrixPicture(const Scene& scene, const std::vector<double>& energies,
                              const std::vector<CameraPair>& pairs);

}  // namespace burin
