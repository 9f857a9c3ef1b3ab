#include "core/evidence/trim.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/facet_labels.h"

namespace burin {
namespace {

// Of values. Without them castle-P30 has 570 loops of borders instead of 420; they cost fountain-P11 .0015 of F1 at 5 mm.
constexpr int kDiffusionSteps = 10;
constexpr int kClearPairs = 2;
constexpr float kLeastCosine = 0.3F;
constexpr float kMostSdPx = 3;
// Of a narrow part's area, and of what pairs see of it. Rods seen from one side have .6 and 0, the fruits of thin-stem .95
// and up to .7; folds of fountain-P11 .1, and plates .5 and .98.
constexpr double kNarrowSeen = 0.4;
constexpr double kNarrowClear = 0.8;
constexpr float kObliqueZncc = 0.4F;
constexpr double kObliquePx = 1000;  // square; the bridges of fountain-P11 are smaller

// Where photographs show no texture, correlation and standard deviation vary from facet to facet.
std::vector<FacetEvidence> WithSmoothValues(const Adjacency& neighbors,
                                            std::vector<FacetEvidence> facets) {
  std::vector<float> zncc;
  std::vector<float> log_sd;
  zncc.reserve(facets.size());
  log_sd.reserve(facets.size());
  for (const FacetEvidence& facet : facets) {
    zncc.push_back(facet.zncc);
    log_sd.push_back(std::log(facet.sd_px));
  }
  DiffuseOverFacets(neighbors, kDiffusionSteps, &zncc);
  DiffuseOverFacets(neighbors, kDiffusionSteps, &log_sd);
  for (size_t f = 0; f < facets.size(); ++f) {
    facets[f].zncc = zncc[f];
    facets[f].sd_px = std::exp(log_sd[f]);
  }
  return facets;
}

bool IsRefuted(const FacetEvidence& facet) {
  return facet.behind > facet.front || 2 * facet.outside > facet.front;
}

// Perhaps of a surface seen at a small angle, and not a bridge.
bool MayBeOblique(const FacetEvidence& facet, CutReason reason) {
  return (reason == CutReason::kUnclear || reason == CutReason::kGrazing) &&
         facet.off_step_pairs >= kClearPairs && facet.zncc >= kObliqueZncc &&
         !(facet.sd_px > kMostSdPx);
}

// Square pixels of a patch.
struct PatchAreas {
  double all = 0;
  double thin = 0;
  double seen = 0;   // by some pair
  double clear = 0;  // of steps, in kClearPairs

  PatchAreas(const std::vector<int>& patch, const std::vector<FacetEvidence>& facets,
             const std::vector<double>& area_px) {
    for (const int f : patch) {
      all += area_px[f];
      if (facets[f].thin) thin += area_px[f];
      if (facets[f].pairs > 0) seen += area_px[f];
      if (facets[f].clear_pairs >= kClearPairs) clear += area_px[f];
    }
  }
  // Folds of the surface are mostly hidden.
  bool IsSeen() const { return seen >= kNarrowSeen * all; }
};

void KeepUnlessRefuted(const std::vector<int>& patch, const std::vector<FacetEvidence>& facets,
                       std::vector<CutReason>* reasons) {
  for (const int f : patch) {
    (*reasons)[f] = IsRefuted(facets[f]) ? CutReason::kRefuted : CutReason::kNone;
  }
}

void KeepNarrowParts(const std::vector<FacetEvidence>& facets, const std::vector<double>& area_px,
                     const Adjacency& neighbors, std::vector<CutReason>* reasons) {
  const std::vector<char> all(facets.size(), 1);
  for (const std::vector<int>& part : FacetPatches(neighbors, all)) {
    const PatchAreas areas(part, facets, area_px);
    if (areas.thin >= areas.all / 2 && areas.IsSeen() && areas.clear < kNarrowClear * areas.seen) {
      KeepUnlessRefuted(part, facets, reasons);
    }
  }
  std::vector<char> narrow;
  narrow.reserve(facets.size());
  for (const FacetEvidence& facet : facets) {
    narrow.push_back(facet.thin && facet.clear_pairs < kClearPairs ? 1 : 0);
  }
  for (const std::vector<int>& patch : FacetPatches(neighbors, narrow)) {
    const PatchAreas areas(patch, facets, area_px);
    if (areas.all >= kLeastPatchPx && areas.IsSeen()) KeepUnlessRefuted(patch, facets, reasons);
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
    if (PatchAreas(patch, facets, area_px).all < kObliquePx) continue;
    for (const int f : patch) (*reasons)[f] = CutReason::kNone;
  }
}

}  // namespace

CutReason JudgeFacet(SurfaceTrim rule, const FacetEvidence& facet) {
  if (rule == SurfaceTrim::kNone) return CutReason::kNone;
  if (facet.pairs == 0 && !facet.outlined) return CutReason::kUnseen;
  if (rule == SurfaceTrim::kUnseen) return CutReason::kNone;
  if (facet.outlined) return IsRefuted(facet) ? CutReason::kRefuted : CutReason::kNone;
  if (facet.clear_pairs < kClearPairs) return CutReason::kUnclear;
  if (facet.cosine < kLeastCosine) return CutReason::kGrazing;
  if (facet.sd_px > kMostSdPx) return CutReason::kUncertain;
  if (facet.zncc < 0) return CutReason::kDisagrees;
  return CutReason::kNone;
}

std::vector<CutReason> FacetsToCut(SurfaceTrim rule, const TriangleMesh& mesh,
                                   const std::vector<FacetEvidence>& measured,
                                   const std::vector<double>& area_px) {
  const Adjacency neighbors = FacetNeighbors(mesh);
  const std::vector<FacetEvidence> facets = WithSmoothValues(neighbors, measured);
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
