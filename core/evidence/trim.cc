#include "core/evidence/trim.h"

#include "core/mesh/facet_labels.h"

namespace burin {
namespace {

constexpr int kClearPairs = 2;
constexpr float kLeastCosine = 0.3F;
constexpr float kMostSdPx = 3;

}  // namespace

CutReason JudgeFacet(SurfaceTrim rule, const FacetEvidence& facet) {
  if (rule == SurfaceTrim::kNone) return CutReason::kNone;
  if (rule == SurfaceTrim::kEvidence && facet.thin) {
    const bool refuted = facet.behind > facet.front || 2 * facet.outside > facet.front;
    return refuted ? CutReason::kRefuted : CutReason::kNone;
  }
  if (facet.pairs == 0) return CutReason::kUnseen;
  if (rule == SurfaceTrim::kUnseen) return CutReason::kNone;
  if (facet.clear_pairs < kClearPairs) return CutReason::kUnclear;
  if (facet.cosine < kLeastCosine) return CutReason::kGrazing;
  if (facet.sd_px > kMostSdPx) return CutReason::kUncertain;
  if (facet.zncc < 0) return CutReason::kDisagrees;
  return CutReason::kNone;
}

std::vector<CutReason> FacetsToCut(SurfaceTrim rule, const TriangleMesh& mesh,
                                   const std::vector<FacetEvidence>& facets,
                                   const std::vector<double>& area_px) {
  std::vector<CutReason> reasons;
  std::vector<char> cut;
  for (const FacetEvidence& facet : facets) {
    reasons.push_back(JudgeFacet(rule, facet));
    cut.push_back(reasons.back() != CutReason::kNone ? 1 : 0);
  }
  const std::vector<char> smoothed = SmoothedLabels(mesh, area_px, cut);
  for (size_t f = 0; f < smoothed.size(); ++f) {
    if (smoothed[f] == 0) reasons[f] = CutReason::kNone;
    if (smoothed[f] != 0 && cut[f] == 0) reasons[f] = CutReason::kSpeck;
  }
  return reasons;
}

}  // namespace burin
