// What the photographs say of every facet of a refined mesh: how many pairs see it, how well, and whether a depth step
// is near. Of every vertex, what is not by pairs.
//
// "px" are pixels of a view's image at the round's level, unless it says otherwise.
#pragma once

#include <vector>

#include "core/evidence/facet_evidence.h"
#include "core/mesh/mesh.h"
#include "core/scene/pyramid.h"
#include "core/visibility/view_domain.h"

namespace burin {

struct SurfaceEvidence {
  std::vector<FacetEvidence> facets;  // zncc, sd_px and thin are left to the caller
  // By vertex, over the views that see one of its facets; 0 where there is none.
  std::vector<float> cosine;  // the largest between its normal and the way to the camera
  std::vector<float>
      step_px;  // the largest distance to a depth step, pixels of the view's full resolution
};

// The frozen round of a mesh. `mesh` may have moved since, `domains` are of the round's start.
struct FrozenSurface {
  const TriangleMesh& mesh;
  const Adjacency& faces;
  const std::vector<char>& boundary;  // vertices
  const std::vector<LevelView>& views;
  const std::vector<ViewDomain>& domains;
};

SurfaceEvidence MeasureSurfaceEvidence(const FrozenSurface& surface);

}  // namespace burin
