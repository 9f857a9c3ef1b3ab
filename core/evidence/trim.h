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
// the first that holds being its reason. Facets of parts too thin to have pixels clear of their own outline are cut only
// on evidence against them: more pixels see them from behind than from the front, or most of those that see them are
// outside of masks (refuted). `unseen` cuts what no pair sees, thin or not.
//
// Labels are then smoothed along the surface (core/mesh/facet_labels.h).
#pragma once

#include <vector>

#include "core/evidence/surface_evidence.h"
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
                                   const std::vector<FacetEvidence>& facets,
                                   const std::vector<double>& area_px);

}  // namespace burin
