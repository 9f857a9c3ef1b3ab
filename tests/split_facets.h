// Options of runs that tests follow vertex by vertex, or level by level.
#pragma once

#include "apps/run/pipeline.h"

namespace burin::test {

// Facets are split on the way; the surface is neither cut anew nor cut away.
inline PipelineOptions SplitFacets() {
  PipelineOptions options;
  options.refinement.surface.remesh = SurfaceFacets::kNone;
  options.surface.trim = SurfaceTrim::kNone;
  return options;
}

}  // namespace burin::test
