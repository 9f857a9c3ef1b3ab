// Measures what the closing line says (apps/run/closing.h).
#pragma once

#include "apps/run/closing.h"
#include "core/mesh/mesh.h"
#include "core/refine/refinement_options.h"
#include "core/refine/refinement_parts.h"
#include "core/scene/scene.h"
#include "costs/photometric_options.h"
#include "costs/vertex_quality.h"
#include "selection/pair_selection.h"

namespace burin {

// Input surface and refined mesh are both seen anew, cut into the same facets, on images of a quarter of the finest
// level's size; on larger ones where these are too small for level.min_side_px, or show too little to be judged by.
// Each is seen by the cameras and in the images that it had: the scene's, the refined ones in `seen` (TrackStep::seen, or the scene). They are compared by the pairs held back or, where there are none, by squares (HeldBackSquares) of one pair of
// every reference view, when the refinement left these squares out.
//
// Against the evidence are vertices around which enough windows count, and the photographs agree no better in them
// than unrelated ones would: their mean ZNCC is below 0.1, in the last round's pairs. Two views must show texture there
// (core/refine/facet_texture.h) of a standard deviation above the variance floor, which alone halves the ZNCC of
// windows that have less. Vertices without such texture are featureless instead: a white wall, or sky behind a
// surface that is not there.
ClosingFigures MeasureClosing(const Scene& scene, const Scene& seen, const TriangleMesh& input,
                              const PairSelection& selection, const LevelOptions& level,
                              const PhotometricOptions& photo, bool squares_were_left_out,
                              const RefinementEnd& end, const VertexQuality& quality);

}  // namespace burin
