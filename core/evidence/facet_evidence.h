// What the photographs say of a facet of a refined mesh (costs/surface_evidence.h measures it).
//
// "px" are pixels of a view's image at the level of the last round, unless it says otherwise.
#pragma once

#include <cstdint>
#include <limits>

namespace burin {

// A pixel this far from every depth step of its view is clear of them. Depths of neighbouring pixels that differ by more
// than kStepPx footprints are a step.
constexpr double kClearPx = 3;
constexpr double kStepPx = 3;

struct FacetEvidence {
  int pairs = 0;        // directed camera pairs that see a pixel of it in both views
  int clear_pairs = 0;  // of these: one that is clear of depth steps in the reference view
  // The same, but what the facets' planes predict is no step: surfaces seen at a small angle have none.
  int off_step_pairs = 0;
  // Of these pairs the best: the smaller of the cosines between the facet's normal and the ways to its two cameras.
  float cosine = 0;
  // Means over its vertices that have the value; NaN where none has.
  float zncc = std::numeric_limits<float>::quiet_NaN();
  float sd_px = std::numeric_limits<float>::quiet_NaN();  // pixels of full resolution
  bool thin = false;  // of a part too thin to have pixels clear of its own outline
  // Outlines of the object place it where no window does: a vertex of it is RoundContext::free.
  bool outlined = false;
  // Pixels of all views that see it: from the front, of these more than kClearPx outside the view's mask, and from behind.
  int64_t front = 0;
  int64_t outside = 0;
  int64_t behind = 0;
};

}  // namespace burin
