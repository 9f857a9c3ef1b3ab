#include "costs/held_back.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/mesh/mesh.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

constexpr int kBatches = 64;

}  // namespace

HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after,
                              const std::vector<int>& facets) {
  double weights[kBatches] = {};
  double changes[kBatches] = {};
  HeldBackVerdict verdict;
  for (size_t k = 0; k < facets.size(); ++k) {
    const int f = facets[k];
    const double weight = std::min(before[f].weight, after[f].weight);
    if (weight <= 0) continue;
    const double e_before = before[f].cost / before[f].weight;
    const double e_after = after[f].cost / after[f].weight;
    const size_t batch = k * kBatches / facets.size();
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
    if (weights[b] > 0) ++verdict.batches;
  }
  if (verdict.batches > 1) square *= verdict.batches / (verdict.batches - 1.0);
  verdict.standard_error = std::sqrt(square) / verdict.windows;
  return verdict;
}

HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after) {
  CHECK_EQ(before.size(), after.size());
  std::vector<int> all(before.size());
  std::iota(all.begin(), all.end(), 0);
  return CompareScores(before, after, all);
}

void HeldBackJudge::BeginLevel(const RoundContext& first, const TermRounds& terms) {
  const Stopwatch watch;
  before_ = photometric_->RoundOf(terms).FacetScores(
      first.mesh->vertices, PhotometricRound::Windows::kHeldBack, /*derivatives=*/false);
  seconds_ = watch.Seconds();
}

LevelVerdict HeldBackJudge::EndLevel(const RoundContext& /*last*/, const TermRounds& terms,
                                     const TriangleMesh& after) {
  const Stopwatch watch;
  const std::vector<FacetScore> scores = photometric_->RoundOf(terms).FacetScores(
      after.vertices, PhotometricRound::Windows::kHeldBack, /*derivatives=*/false);
  LevelVerdict level;
  level.undo.assign(after.vertices.size(), 0);
  std::vector<int> kept;
  for (const std::vector<int>& part : ConnectedComponents(after)) {
    if (!CompareScores(before_, scores, part).Worse()) {
      kept.insert(kept.end(), part.begin(), part.end());
      continue;
    }
    for (const int f : part) {
      for (const int v : after.faces[f]) level.undo[v] = 1;
    }
  }
  std::sort(kept.begin(), kept.end());
  const HeldBackVerdict rest = CompareScores(before_, scores, kept);
  if (rest.windows <= 0 || rest.Worse()) level.undo.assign(after.vertices.size(), 1);
  const HeldBackVerdict verdict = CompareScores(before_, scores);
  before_.clear();
  level.report = {{"before", verdict.before},
                  {"after", verdict.after},
                  {"standard_error", verdict.standard_error},
                  {"windows", std::round(verdict.windows)},
                  {"seconds", seconds_ + watch.Seconds()}};
  return level;
}

}  // namespace burin
