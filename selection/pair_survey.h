// What the mesh says about every camera pair: the facets that each view sees, and the terms of
// pair_terms.h averaged over Omega_ij, the pixels of view i whose surface point view j sees too.
//
// Cost: one cast per view, at a low resolution, finds the facets that the view sees. Only pairs that share
// a facet are integrated, at that resolution, over Omega_ij as the energy defines it
// (core/visibility/visibility.h). docs/camera_pairs.md has the error against full resolution and the growth
// with the number of views.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "selection/facet_sets.h"
#include "selection/pair_terms.h"

namespace burin {

struct SurveyOptions {
  int resolution_px = 128;      // longer side of the images integrated over; never above the
                                // view's own
  double min_parallax_deg = 0;  // the range of PairMeasure::area_in_range, inclusive
  double max_parallax_deg = 180;
};

struct PairSurvey {
  int view_count = 0;
  std::vector<PairMeasure> measures;  // (i, j) at i * view_count + j
  std::vector<double> seen;           // share of each view's image that sees the front of the mesh,
                                      // on pixels that are used
  // A facet is seen by a view when it faces it and its centroid is visible or a pixel of the cast
  // hits it, masked or not: coverage evens out what cameras can see, and a hole that a mask cuts must
  // not turn it away from a whole view.
  FacetSets facets;

  const PairMeasure& At(int i, int j) const {
    return measures[static_cast<size_t>(i) * view_count + j];
  }
};

// Means use the facet's normal as the normal of the surface. Depends on cameras, mesh and masks only: a
// pixel of the survey is used when the mask allows at least half of it, and Omega_ij has only pixels that
// are used in both views.
PairSurvey SurveyPairs(const Scene& scene, const TriangleMesh& mesh, const SurveyOptions& options);

}  // namespace burin
