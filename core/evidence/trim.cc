#include "core/evidence/trim.h"

#include <algorithm>

#include "core/mesh/facet_labels.h"

namespace burin {
namespace {

constexpr int kClearPairs = 2;
constexpr float kLeastCosine = 0.3F;
constexpr float kMostSdPx = 3;
constexpr double kNarrowSeen = 0.4;  // of a narrow part's area
constexpr float kObliqueZncc = 0.4F;
constexpr double kObliquePx = 1000;  // square; the bridges of fountain-P11 are smaller

bool IsRefuted(const FacetEvidence& facet) {
  return facet.behind > facet.front || 2 * facet.outside > facet.front;
}

// Of a part that is perhaps too thin to have pixels clear of its own outline.
bool MayBeNarrow(const FacetEvidence& facet) {
  return facet.thin && facet.clear_pairs < kClearPairs;
}

// Perhaps of a surface seen at a small angle, and not a bridge.
bool MayBeOblique(const FacetEvidence& facet, CutReason reason) {
  return (reason == CutReason::kUnclear || reason == CutReason::kGrazing) &&
         facet.off_step_pairs >= kClearPairs && facet.zncc >= kObliqueZncc &&
         !(facet.sd_px > kMostSdPx);
}

double AreaOf(const std::vector<int>& patch, const std::vector<double>& area_px) {
  double area = 0;
  for (const int f : patch) area += area_px[f];
  return area;
}

void KeepNarrowParts(const std::vector<FacetEvidence>& facets, const std::vector<double>& area_px,
                     const Adjacency& neighbors, std::vector<CutReason>* reasons) {
  std::vector<char> narrow;
  narrow.reserve(facets.size());
  for (const FacetEvidence& facet : facets) narrow.push_back(MayBeNarrow(facet) ? 1 : 0);
  for (const std::vector<int>& patch : FacetPatches(neighbors, narrow)) {
    double seen = 0;
    bool borders = false;
    for (const int f : patch) {
      if (facets[f].pairs > 0) seen += area_px[f];
      borders |=
          std::any_of(neighbors.Begin(f), neighbors.End(f), [&](int n) { return narrow[n] == 0; });
    }
    const double area = AreaOf(patch, area_px);
    if (seen < kNarrowSeen * area || (borders && area < kLeastPatchPx)) continue;
    for (const int f : patch) {
      (*reasons)[f] = IsRefuted(facets[f]) ? CutReason::kRefuted : CutReason::kNone;
    }
  }
}

void KeepObliqueSurfaces(const std::vector<FacetEvidence>& facets,
                         const std::vector<double>& area_px, const Adjacency& neighbors,
                         std::vector<CutReason>* reasons) {
  std::vector<char> oblique;
  oblique.reserve(facets.size());
  for (size_t f = 0; f < facets.size(); ++f) {
    oblique.push_back(MayBeOblique(facets[f], (*reasons)[f]) ? 1 : 0);
  }
  for (const std::vector<int>& patch : FacetPatches(neighbors, oblique)) {
    if (AreaOf(patch, area_px) < kObliquePx) continue;
    for (const int f : patch) (*reasons)[f] = CutReason::kNone;
  }
}

}  // namespace

CutReason JudgeFacet(SurfaceTrim rule, const FacetEvidence& facet) {
  if (rule == SurfaceTrim::kNone) return CutReason::kNone;
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
  const Adjacency neighbors = FacetNeighbors(mesh);
  std::vector<CutReason> reasons;
  reasons.reserve(facets.size());
  for (const FacetEvidence& facet : facets) reasons.push_back(JudgeFacet(rule, facet));
  if (rule == SurfaceTrim::kEvidence) {
    KeepNarrowParts(facets, area_px, neighbors, &reasons);
    KeepObliqueSurfaces(facets, area_px, neighbors, &reasons);
  }
  std::vector<char> cut;
  cut.reserve(reasons.size());
  for (const CutReason reason : reasons) cut.push_back(reason != CutReason::kNone ? 1 : 0);
  const std::vector<char> smoothed = SmoothedLabels(mesh, neighbors, area_px, cut);
  for (size_t f = 0; f < smoothed.size(); ++f) {
    if (smoothed[f] == 0) reasons[f] = CutReason::kNone;
    if (smoothed[f] != 0 && cut[f] == 0) reasons[f] = CutReason::kSpeck;
  }
  return reasons;
}

}  // namespace burin
