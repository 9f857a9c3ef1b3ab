// The files of a comparison of strategies: compare.csv and compare.json. `apps/study charts` draws the
// first, so it holds all that a chart says.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "apps/run/solver_comparison.h"

namespace burin {

// mode,strategy,level,round,width,height,faces,unknowns,cameras,pairs,iteration,evaluations,seconds,
// energy,rmse,camera_px,accepted,note
// For each strategy a line an iteration (see ComparisonRow), then a line for each round, or run,
// without a result: the reason in quotes as the note, the fields from `iteration` on empty and, of a
// run, also `level` to `cameras`. rmse is empty where it was not measured, camera_px where cameras are no unknowns. `level` is that of
// level.finest: 0 = full resolution; `width` and `height` are those of its first view.
std::string ComparisonCsv(const Comparison& comparison);

enum class ComparedStatus { kOk, kPartly, kRefused, kFailed };  // kPartly: some rounds
inline Choices<ComparedStatus> ChoicesOf(ComparedStatus) {
  return {{ComparedStatus::kOk, "ok"},
          {ComparedStatus::kPartly, "partly"},
          {ComparedStatus::kRefused, "refused"},
          {ComparedStatus::kFailed, "failed"}};
}

// Over the rounds of a strategy that have a result. `reduction_share` is the mean over them of
//   (E_start - E_end) / (E_start - E_best),  E_best the lowest energy any strategy ended the round with
// (mode frozen only, else NaN: energies of different rounds do not compare).
struct StrategyTotals {
  ComparedStatus status = ComparedStatus::kOk;
  std::string reason;                    // the first one
  double energy_initial = kNotMeasured;  // of the last round with a result
  double energy_final = kNotMeasured;
  double rmse = kNotMeasured;
  double seconds = 0;
  int iterations = 0;
  int64_t evaluations = 0;
  double reduction_share = kNotMeasured;
};
StrategyTotals TotalsOf(const Comparison& comparison, const ComparedStrategy& strategy);

// The "strategies", "before" and "rounds" of compare.json.
nlohmann::ordered_json ComparisonJson(const Comparison& comparison);

// A line a strategy; and of every round with cameras among its unknowns a table of its own.
std::string ComparisonTable(const Comparison& comparison);

}  // namespace burin
