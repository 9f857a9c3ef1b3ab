// What is known of the surface that a refinement ends with: values by vertex, and which facets are cut away.
#pragma once

#include <vector>

#include "core/evidence/trim.h"
#include "core/mesh/mesh_io.h"
#include "core/refine/refinement_parts.h"
#include "costs/vertex_quality.h"

namespace burin {

// By vertex and facet of the mesh that Refine() returns.
struct SurfaceQuality {
  // pairs, zncc, displacement_px, sd_px, cosine, step_px (docs/surface.md). Lengths are in pixel footprints of the
  // sharpest view (full resolution) whose image the vertex projects into, NaN where there is none.
  std::vector<VertexScalar> scalars;
  std::vector<CutReason> reasons;
};

SurfaceQuality MeasureSurface(const RefinementEnd& reached, const VertexQuality& quality,
                              SurfaceTrim rule);

}  // namespace burin
