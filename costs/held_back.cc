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
constexpr double kAllowedLoss = 0.05;  // by fewer facets, of the gain before

// Sums over pieces of surface, in batches of neighbouring ones.
class Comparison {
 public:
  void Add(size_t batch, double weight, double e_before, double e_after) {
    weights_[batch] += weight;
    changes_[batch] += weight * (e_after - e_before);
    verdict_.before += weight * e_before;
    verdict_.after += weight * e_after;
    verdict_.windows += weight;
  }

  HeldBackVerdict Verdict() {
    HeldBackVerdict verdict = verdict_;
    if (verdict.windows <= 0) return verdict;
    verdict.before /= verdict.windows;
    verdict.after /= verdict.windows;
    const double mean = verdict.after - verdict.before;
    double square = 0;
    for (int b = 0; b < kBatches; ++b) {
      const double residual = changes_[b] - weights_[b] * mean;
      square += residual * residual;
      if (weights_[b] > 0) ++verdict.batches;
    }
    if (verdict.batches > 1) square *= verdict.batches / (verdict.batches - 1.0);
    verdict.standard_error = std::sqrt(square) / verdict.windows;
    return verdict;
  }

 private:
  double weights_[kBatches] = {};
  double changes_[kBatches] = {};
  HeldBackVerdict verdict_;
};

// Whether outlines alone placed some of the surface: then no window need say anything.
bool HasOutlines(const RoundContext& context) {
  return std::find(context.free.begin(), context.free.end(), 1) != context.free.end();
}

bool IsBefore(const CellScore& a, const CellScore& b) {
  return a.view != b.view ? a.view < b.view : a.cell < b.cell;
}

}  // namespace

HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after,
                              const std::vector<int>& facets) {
  Comparison comparison;
  for (size_t k = 0; k < facets.size(); ++k) {
    const int f = facets[k];
    const double weight = std::min(before[f].weight, after[f].weight);
    if (weight <= 0) continue;
    comparison.Add(k * kBatches / facets.size(), weight, before[f].cost / before[f].weight,
                   after[f].cost / after[f].weight);
  }
  return comparison.Verdict();
}

HeldBackVerdict CompareScores(const std::vector<CellScore>& before,
                              const std::vector<CellScore>& after) {
  Comparison comparison;
  auto now = after.begin();
  for (size_t k = 0; k < before.size(); ++k) {
    const CellScore& was = before[k];
    while (now != after.end() && IsBefore(*now, was)) ++now;
    if (now == after.end()) break;
    if (IsBefore(was, *now)) continue;
    comparison.Add(k * kBatches / before.size(), std::min(was.weight, now->weight),
                   was.cost / was.weight, now->cost / now->weight);
  }
  return comparison.Verdict();
}

HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after) {
  CHECK_EQ(before.size(), after.size());
  std::vector<int> all(before.size());
  std::iota(all.begin(), all.end(), 0);
  return CompareScores(before, after, all);
}

void HeldBackJudge::BeginLevel(const RoundContext& first, const TermRounds& terms,
                               LevelFacets facets, const nlohmann::json& report) {
  const Stopwatch watch;
  facets_ = facets;
  allowed_ = 0;
  if (report.is_object() && report.contains("before")) {
    allowed_ = kAllowedLoss *
               std::max(0.0, report["before"].get<double>() - report["after"].get<double>());
  }
  PhotometricRound& round = photometric_->RoundOf(terms);
  const std::vector<Eigen::Vector3d>& vertices = first.mesh->vertices;
  if (facets_ == LevelFacets::kOther) {
    before_cells_ = round.CellScores(vertices, PhotometricRound::Windows::kHeldBack);
  } else {
    before_ = round.FacetScores(vertices, PhotometricRound::Windows::kHeldBack,
                                /*derivatives=*/false);
  }
  seconds_ = watch.Seconds();
}

LevelVerdict HeldBackJudge::EndLevel(const RoundContext& last, const TermRounds& terms,
                                     const TriangleMesh& after) {
  const Stopwatch watch;
  PhotometricRound& round = photometric_->RoundOf(terms);
  LevelVerdict level;
  level.undo.assign(after.vertices.size(), 0);
  HeldBackVerdict verdict;
  if (facets_ == LevelFacets::kOther) {
    verdict = CompareScores(before_cells_,
                            round.CellScores(after.vertices, PhotometricRound::Windows::kHeldBack));
    if ((verdict.windows <= 0 && !HasOutlines(last)) ||
        (verdict.Worse() && verdict.after - verdict.before > allowed_))
      level.undo.assign(after.vertices.size(), 1);
  } else {
    verdict = JudgeParts(round.FacetScores(after.vertices, PhotometricRound::Windows::kHeldBack,
                                           /*derivatives=*/false),
                         after, HasOutlines(last), &level.undo);
  }
  before_ = {};
  before_cells_ = {};
  level.report = {{"before", verdict.before},
                  {"after", verdict.after},
                  {"standard_error", verdict.standard_error},
                  {"windows", std::round(verdict.windows)},
                  {"seconds", seconds_ + watch.Seconds()}};
  return level;
}

HeldBackVerdict HeldBackJudge::JudgeParts(const std::vector<FacetScore>& scores,
                                          const TriangleMesh& after, bool outlines,
                                          std::vector<char>* undo) const {
  std::vector<int> kept;
  for (const std::vector<int>& part : ConnectedComponents(after)) {
    if (!CompareScores(before_, scores, part).Worse()) {
      kept.insert(kept.end(), part.begin(), part.end());
      continue;
    }
    for (const int f : part) {
      for (const int v : after.faces[f]) (*undo)[v] = 1;
    }
  }
  std::sort(kept.begin(), kept.end());
  const HeldBackVerdict rest = CompareScores(before_, scores, kept);
  if ((rest.windows <= 0 && !outlines) || rest.Worse()) undo->assign(after.vertices.size(), 1);
  return CompareScores(before_, scores);
}

}  // namespace burin
