// What the mesh says about every camera pair: the facets that each view sees, and the terms of
// pair_terms.h averaged over Omega_ij, the pixels of view i whose surface point view j sees too.
//
// Cost: one facet map per view, at a low resolution, finds the facets that the view sees. Pairs that share
// a facet, or those of them that an estimate finds best (pair_estimate.h), are integrated at that resolution
// over Omega_ij as the energy defines it (core/visibility/visibility.h). docs/camera_pairs.md has the error
// against full resolution and the growth with the number of views.
#pragma once

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"
#include "core/visibility/visibility.h"
#include "selection/facet_sets.h"
#include "selection/pair_estimate.h"
#include "selection/pair_sums.h"
#include "selection/pair_terms.h"

namespace burin {

struct SurveyOptions {
  int resolution_px = 128;  // longer side of the images integrated over; never above the view's own
  ParallaxRange parallax;   // of PairMeasure::area_in_range
};

struct PairSurvey {
  int view_count = 0;
  std::vector<PairMeasure> measures;  // (i, j) at i * view_count + j; nothing where not measured
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

// Makes a survey, pair by pair. Means use the facet's normal as the normal of the surface. Depends on cameras,
// mesh and masks only: a pixel of the survey is used when the mask allows at least half of it, and Omega_ij
// has only pixels that are used in both views.
class PairSurveyor {
 public:
  // What is looked for in the views besides what they see. `facets` are those of the survey; `points` are
  // those of the estimate.
  struct Wanted {
    bool facets = true;
    bool points = true;
  };

  PairSurveyor(const Scene& scene, const TriangleMesh& mesh, const SurveyOptions& options,
               const Wanted& wanted);

  const PairSurvey& survey() const { return survey_; }
  PairSurvey Take() { return std::move(survey_); }  // the end of this

  // Those of the pairs that are not measured yet; returns whether there were any. Pairs that share no facet,
  // where facets are known, share nothing.
  bool Measure(const std::vector<CameraPair>& pairs);
  // The same for every pair of `references` with another view.
  bool MeasureAllOf(const std::vector<int>& references);

  // Where points were wanted; the next call has none.
  PairEstimate TakeEstimate() { return std::move(estimate_); }

 private:
  void LookFrom(int view, const std::vector<Eigen::Vector3d>& centroids, const Wanted& wanted);
  void AddHiddenFacets(int view, const std::vector<Eigen::Vector3d>& centroids);
  void MeasureTogether(const std::vector<CameraPair>& pairs);

  const TriangleMesh& mesh_;
  SurveyOptions options_;
  bool has_facets_;
  std::vector<Camera> cameras_;
  std::vector<cv::Mat> masks_;  // empty where a view has none
  RayCaster caster_;
  PairEstimate estimate_;
  std::vector<char> measured_;  // (i, j) at i * view_count + j
  PairSurvey survey_;
};

// 0 to view_count - 1.
std::vector<int> AllViews(int view_count);

// All pairs.
PairSurvey SurveyPairs(const Scene& scene, const TriangleMesh& mesh, const SurveyOptions& options);

}  // namespace burin
