// The files of a comparison of strategies: compare.csv, compare.json and charts.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/run/solver_comparison.h"

namespace burin {

// strategy,level,round,iteration,evaluations,seconds,energy,rmse,accepted,note
// A line an iteration (see ComparisonRow), then a line for each round, or run, without a result, with
// the reason in quotes as the note and the other fields empty. rmse is empty where it was not
// measured. `level` is that of level.finest: 0 = full resolution.
std::string ComparisonCsv(const Comparison& comparison);

// Over the rounds of a strategy that have a result. `reduction_share` is the mean over them of
//   (E_start - E_end) / (E_start - E_best),  E_best the lowest energy any strategy ended the round with
// (mode frozen only, else NaN: energies of different rounds do not compare).
struct StrategyTotals {
  std::string status;                    // ok, partly (some rounds), refused, failed
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

// A line a strategy.
std::string ComparisonTable(const Comparison& comparison);

struct NamedChart {
  std::string file;  // relative to the output folder
  std::string svg;
};

// compare.svg: energy and, with a truth, error, against evaluations and against seconds. Mode whole
// has this one over the whole run. Mode frozen has one a round, rounds/level<L>_round<R>.svg, and
// compare.svg repeats that of the round whose energy falls most, as a share of its start.
std::vector<NamedChart> ComparisonCharts(const Comparison& comparison);

}  // namespace burin
