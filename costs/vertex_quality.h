// How well the photographs determine each vertex of a refined mesh.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "costs/photometric_round.h"

namespace burin {

// A value per vertex; NaN where it is not defined.
struct VertexQuality {
  // Pairs (i, j) that see a pixel of a facet at the vertex in both views.
  std::vector<float> pairs;
  // Mean ZNCC of the windows centred in the vertex's facets, weighted by omega.
  std::vector<float> zncc;
  std::vector<float> windows;  // sum of these omega; 0 where there is none
  // Standard deviation of the vertex along its normal, in the unit of `mesh`:
  //
  //   sd^2 = tau^2 / H_vv,   tau^2 = 2 sum omega (1 - z) / sum omega   over the windows of its facets
  //
  // E is half the sum over pixels of squared residuals d / s, d the difference of grey levels and s
  // the window's contrast, because each pixel is in as many windows as a window has taps. tau^2 is the
  // variance of d / s and H the Gauss-Newton matrix of E, so tau^2 H^-1 is the covariance for
  // independent residuals; here with the neighbours held fixed. Pairs that share a photograph share
  // its noise, which here counts as if it were each pair's own: sd is too small by about the square
  // root of two where every pair is used in both directions, by more with several partners. Against
  // an exact mesh it is right to a factor of two (docs/guard_figures.md, "An exact mesh";
  // WeakEvidence.AnExactMeshStaysWithinTheNoiseFloor).
  std::vector<float> sd;
};

// `mesh` has the facets of the round, whose visibility counts.
VertexQuality MeasureVertexQuality(const TriangleMesh& mesh, PhotometricRound* round);

}  // namespace burin
