// How large a mesh is in the views of a scene, and into how many faces a level will split it: what can
// be known of a refinement before it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"

namespace burin {

// At full resolution.
struct SurfaceInViews {
  std::vector<double>
      sharpest_area;            // per face, px^2 (core/mesh/projected_area.h); 0 = seen by nobody
  std::vector<double> covered;  // per view, px^2 of the faces that face it, at most the image
  double views_per_area = 0;    // by how many views a piece of surface is faced
};
SurfaceInViews LookAtSurface(const Scene& scene, const TriangleMesh& mesh);

// Faces after SplitLargeFaces at `max_facet_px` of a level: a face of area A > max becomes
// 2^ceil(log2(A / max)) by bisection, and its neighbours are split along.
int64_t ExpectedFaces(const SurfaceInViews& surface, double max_facet_px, int level);

}  // namespace burin
