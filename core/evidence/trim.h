// Which facets of a refined mesh are no evident surface, and are cut away.
//
// The rule `evidence` cuts a facet that
//
//   no pair sees                                                                    unseen
//   fewer than 2 pairs see clear of depth steps in the reference view               unclear
//   the best pair sees at a cosine below .3: a bridge over a depth step             grazing
//   has a standard deviation above 3 px                                             uncertain
//   has a correlation below 0                                                       disagrees
//
// the first that holds being its reason; standard deviation and correlation are those around it (ten steps of diffusion over
// facets that share an edge). `unseen` cuts what no pair sees.
//
// What outlines of the object's masks place counts as seen: it is cut by `evidence` where it is refuted (below), and for
// no other reason.
//
// Two kinds of surface are kept by `evidence` all the same:
//
//   narrow parts, as rods and stems, which have few pixels clear of their own outline, or none: connected parts of
//     the mesh of which half is thin (FacetEvidence::thin), .4 is seen by pairs, and of that less than .8 by 2 pairs clear;
//     on other parts patches of thin facets that fewer than 2 pairs see clear, of 200 square pixels, of which .4 is seen
//     (folds of the surface are mostly hidden). There a facet is cut only on evidence against it: more pixels see it from
//     behind than from the front, or most that see it are outside of masks (refuted).
//   oblique surfaces, as the ground before a tower, which have depth steps between neighbouring pixels for no other reason
//     than their angle. Patches of unclear and grazing facets with a correlation of .4, seen by 2 pairs clear of the steps
//     that their planes do not predict, of 1000 square pixels: bridges are smaller.
//
// Labels are then smoothed along the surface (core/mesh/facet_labels.h).
#pragma once

#include <vector>

#include "core/evidence/facet_evidence.h"
#include "core/mesh/mesh.h"
#include "core/support/choices.h"

namespace burin {

enum class SurfaceTrim { kNone, kUnseen, kEvidence };
inline Choices<SurfaceTrim> ChoicesOf(SurfaceTrim) {
  return {{SurfaceTrim::kNone, "none"},
          {SurfaceTrim::kUnseen, "unseen"},
          {SurfaceTrim::kEvidence, "evidence"}};
}

// Why a facet is cut; kNone: it is kept. kFreeSpace: photographs see through it (core/evidence/free_space.h). kSpeck:
// the rule keeps it, but not what is around it.
enum class CutReason : char {
  kNone,
  kUnseen,
  kUnclear,
  kGrazing,
  kUncertain,
  kDisagrees,
  kRefuted,
  kFreeSpace,
  kSpeck
};
inline Choices<CutReason> ChoicesOf(CutReason) {
  return {{CutReason::kNone, "none"},           {CutReason::kUnseen, "unseen"},
          {CutReason::kUnclear, "unclear"},     {CutReason::kGrazing, "grazing"},
          {CutReason::kUncertain, "uncertain"}, {CutReason::kDisagrees, "disagrees"},
          {CutReason::kRefuted, "refuted"},     {CutReason::kFreeSpace, "free_space"},
          {CutReason::kSpeck, "speck"}};
}

CutReason JudgeFacet(SurfaceTrim rule, const FacetEvidence& facet);

// By facet of `mesh`. `area_px` are the facets' areas in square pixels.
std::vector<CutReason> FacetsToCut(SurfaceTrim rule, const TriangleMesh& mesh,
                                   const std::vector<FacetEvidence>& measured,
                                   const std::vector<double>& area_px);

}  // namespace burin
