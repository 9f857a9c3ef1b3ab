// Peak memory of a refinement, estimated from what is known before it: cameras, mesh, options.
//
// The peak is reached while a round of some level is solved; everything counted here is alive then. What
// a vertex, facet or pixel costs is the sum over the structs that are kept for it. It is in one table,
// kCost in the .cc. When burin keeps more or less than before, correct the table and measure again as
// docs/performance.md says. That page also states the accuracy. 1 MiB = 2^20 bytes, 1 GB = 1024 MiB.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/pipeline.h"
#include "apps/run/surface_in_views.h"
#include "core/mesh/mesh.h"
#include "core/scene/scene.h"

namespace burin {

// The numbers that the memory of one level depends on.
struct LevelLoad {
  int level = 0;
  double scene_bytes = 0;     // photographs as loaded
  double level_pixels = 0;    // of all views
  double covered_pixels = 0;  // of all views
  double largest_view = 0;    // pixels
  double domain_bytes = 0;    // bytes a pixel for the partners of a view
  double vertices = 0;
  double faces = 0;
  double visible_facets = 0;  // summed over views
  double view_facets = 0;     // visible in the view that sees most
  double joint_partners = 0;  // of a view, where rounds of the level move cameras; else 0
  double held_bytes = 0;      // what the command keeps beside scene and mesh
  double points = 0;          // of the scene
  double threads = 1;
  double field_bytes = 4;  // of a number in pixel fields: 4, or 8 in double precision
  int unknowns_per_vertex = 1;
  double stencil = 7;  // vertices of a smoothness residual; 0 = none
  bool masks = true;
  double window = 5;                   // taps along a side
  std::string solver = "lm_cholesky";  // as resolved; unknown names cost like lm_cholesky
};

struct MemoryEstimate {
  int level = 0;  // where the peak is
  int64_t vertices = 0;
  int64_t faces = 0;
  std::vector<std::pair<std::string, double>> parts;  // MiB
  double Mib() const;
};

// Never decreases when a number of `load` grows.
MemoryEstimate EstimateLevel(const LevelLoad& load);

// The largest over the levels of a run. Images of the scene need not be loaded; what the command
// holds beside scene and mesh is `held_bytes`.
MemoryEstimate EstimateMemory(const Scene& scene, const TriangleMesh& mesh,
                              const SurfaceInViews& surface, const PipelineOptions& options,
                              double held_bytes = 0);

}  // namespace burin
