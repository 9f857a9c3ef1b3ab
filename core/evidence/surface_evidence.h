// What the photographs say of every facet of a refined mesh: how many pairs see it, how well, and whether a depth step
// is near. Of every vertex, what is not by pairs.
//
// "px" are pixels of a view's image at the round's level, unless it says otherwise.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pyramid.h"
#include "core/visibility/view_domain.h"

namespace burin {

// A pixel this far from every depth step of its view is clear of them. Depths of neighbouring pixels that differ by more
// than kStepPx footprints are a step: a facet seen at a cosine below some .3 is one itself.
constexpr double kClearPx = 3;
constexpr double kStepPx = 3;

struct FacetEvidence {
  int pairs = 0;        // directed camera pairs that see a pixel of it in both views
  int clear_pairs = 0;  // of these: one that is clear of depth steps in the reference view
  // Of these pairs the best: the smaller of the cosines between the facet's normal and the ways to its two cameras.
  float cosine = 0;
  // Means over its vertices that have the value; NaN where none has.
  float zncc = std::numeric_limits<float>::quiet_NaN();
  float sd_px = std::numeric_limits<float>::quiet_NaN();  // pixels of full resolution
  bool thin = false;  // of a part too thin to have pixels clear of its own outline
  // Pixels of all views that see it: from the front, of these more than kClearPx outside the view's mask, and from behind.
  int64_t front = 0;
  int64_t outside = 0;
  int64_t behind = 0;
};

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
