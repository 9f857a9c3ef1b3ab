// Camera pairs from the mesh alone, for scenes without sparse points: for each camera the partners
// with which it shares the most surface under a parallax in a given range.
//
// A facet is visible in a view when its centroid projects inside the image, the facet faces the
// camera and nothing lies between. The score of (i, j) is the area in view i's image of the facets
// visible in both whose parallax (angle at the centroid between the two camera centres) lies in
// [min_deg, max_deg].
#pragma once

#include <vector>

#include "core/mesh.h"
#include "core/pairs.h"
#include "core/scene.h"

namespace burin {

// Score of (i, j) at i * views + j, square pixels of view i; zero diagonal.
std::vector<double> SharedFacetAreas(const Scene& scene, const TriangleMesh& mesh, double min_deg,
                                     double max_deg);

// For each view the `per_camera` best partners by SharedFacetAreas, best first, ties by lower
// index. A view that shares nothing with any other gets no pair.
std::vector<CameraPair> MeshParallaxPairs(const Scene& scene, const TriangleMesh& mesh,
                                          int per_camera, double min_deg, double max_deg);

}  // namespace burin
