#include "costs/held_back.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "core/round.h"

namespace burin {
namespace {

constexpr int kBatches = 64;

void Add(const std::vector<FacetScore>& scores, std::vector<FacetScore>* sum) {
  sum->resize(scores.size());
  for (size_t f = 0; f < scores.size(); ++f) {
    (*sum)[f].cost += scores[f].cost;
    (*sum)[f].weight += scores[f].weight;
  }
}

}  // namespace

HeldBackVerdict CompareOnHeldBack(const std::vector<LevelView>& views,
                                  const std::vector<CameraPair>& pairs,
                                  const std::vector<CameraPair>& used_pairs, double border_px,
                                  const TriangleMesh& before, const TriangleMesh& after,
                                  PhotometricEnergy* photometric) {
  CHECK_EQ(before.faces.size(), after.faces.size());
  const bool squares = pairs.empty();
  std::vector<FacetScore> score_before;
  std::vector<FacetScore> score_after;
  for (const TriangleMesh* visible : {&before, &after}) {
    std::vector<ViewDomain> domains;
    const RoundContext context = FreezeRound(views, squares ? used_pairs : pairs, *visible,
                                             Motion::kNormal, border_px, &domains);
    photometric->HoldBackSquares(false);
    photometric->BeginRound(context);
    Add(photometric->FacetScores(before.vertices, squares), &score_before);
    Add(photometric->FacetScores(after.vertices, squares), &score_after);
    photometric->HoldBackSquares(squares);
  }
  const size_t count = before.faces.size();
  double weights[kBatches] = {};
  double changes[kBatches] = {};
  HeldBackVerdict verdict;
  for (size_t f = 0; f < count; ++f) {
    const double weight = std::min(score_before[f].weight, score_after[f].weight);
    if (weight <= 0) continue;
    const double e_before = score_before[f].cost / score_before[f].weight;
    const double e_after = score_after[f].cost / score_after[f].weight;
    const size_t batch = f * kBatches / count;
    weights[batch] += weight;
    changes[batch] += weight * (e_after - e_before);
    verdict.before += weight * e_before;
    verdict.after += weight * e_after;
    verdict.windows += weight;
  }
  if (verdict.windows <= 0) return verdict;
  verdict.before /= verdict.windows;
  verdict.after /= verdict.windows;
  const double mean = verdict.after - verdict.before;
  double square = 0;
  for (int b = 0; b < kBatches; ++b) {
    const double residual = changes[b] - weights[b] * mean;
    square += residual * residual;
  }
  verdict.standard_error = std::sqrt(square) / verdict.windows;
  return verdict;
}

}  // namespace burin
