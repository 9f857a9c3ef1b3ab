// Runs every strategy from the same start and records what each did. `burin compare-solvers` writes the
// records.
//
// Two questions, two modes:
//   frozen  Which strategy is best at the problem a round poses? A reference run (solver.type) makes
//           the rounds. In each round every strategy solves the same problem (mesh, visibility,
//           masks, pairs) from the same vertices, with nothing evaluated yet. Then the reference's
//           result starts the next round. Nothing but the strategy differs.
//   whole   Which strategy gives the best mesh? Each makes a whole run of its own. From the second
//           round on each has its own mesh and visibility. So only the error to the truth can be
//           compared, not the energies.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"

namespace burin {

// See above.
enum class CompareMode { kFrozen, kWhole };
inline Choices<CompareMode> ChoicesOf(CompareMode) {
  return {{CompareMode::kFrozen, "frozen"}, {CompareMode::kWhole, "whole"}};
}

// When the error to the truth is measured: after every iteration, or at the start and end of a round.
enum class ErrorMeasured { kEveryIteration, kEveryRound };
inline Choices<ErrorMeasured> ChoicesOf(ErrorMeasured) {
  return {{ErrorMeasured::kEveryIteration, "iteration"}, {ErrorMeasured::kEveryRound, "round"}};
}

struct CompareOptions {
  CompareMode mode = CompareMode::kFrozen;
  std::string solvers;  // separated by commas; empty = all
  ErrorMeasured error = ErrorMeasured::kEveryIteration;
  EvaluationOptions evaluation;
  CompareOptions() { evaluation.sample_count = 100000; }  // measured often
  void Describe(OptionSet* set);
  // The strategies asked for, in the order of Strategies(). Throws InputError for names that are
  // none.
  std::vector<std::string> Names() const;
};

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// One iteration of one strategy, or what it returned where that is not its last reported iteration
// (see FrozenRound::solve). In mode frozen `evaluations` and `seconds` count from the start of
// the round, in mode whole from the start of the run. Seconds are of solving alone: not of freezing
// and building rounds, nor of measuring errors.
struct ComparisonRow {
  std::string strategy;
  int level = 0;
  int round = 0;
  int iteration = 0;
  int64_t evaluations = 0;
  double seconds = 0;
  double energy = 0;                // of the vertices the iteration ended with
  double rmse = kNotMeasured;       // to the truth, world units
  double camera_px = kNotMeasured;  // where cameras move: by how much (FrozenRound::Progress)
  bool accepted = true;             // false: the vertices are those of the row before
};

// What a strategy made of a round.
struct ComparedRound {
  int level = 0;
  int round = 0;
  int width = 0;  // of the first view
  int height = 0;
  int vertices = 0;
  int faces = 0;
  int unknowns = 0;
  int cameras = 0;     // among these
  std::string reason;  // why it has no result; empty when it has one
  RoundTrial trial;    // its vertices are dropped
  double rmse_start = kNotMeasured;
  double rmse = kNotMeasured;
};

struct ComparedStrategy {
  std::string name;
  std::string reason;                 // mode whole: why the run ended early; else empty
  std::vector<ComparedRound> rounds;  // as many as were begun
  bool evaluated = false;
  Evaluation evaluation;  // of the mesh after its last round
};

struct Comparison {
  CompareOptions options;
  std::vector<std::string>
      references;  // mode frozen: the strategy that made each round's successor
  PairSelection selection;
  std::vector<ComparedStrategy> strategies;
  std::vector<ComparisonRow> rows;  // by strategy, then in order of time
  bool has_truth = false;
  Evaluation before;  // of the mesh given

  // Some strategy has a result.
  bool AnythingRan() const;
};

// `truth` may be null. `say` gets a line after every trial. `selection` may hold what SelectPairs made, or
// pairs chosen otherwise. Throws InputError for anything wrong with scene, mesh or options; what goes wrong
// with one strategy is kept as its reason.
Comparison CompareSolvers(const Scene& scene, const TriangleMesh& mesh,
                          const PipelineOptions& pipeline, const CompareOptions& options,
                          const Truth* truth, const std::function<void(const std::string&)>& say,
                          const PairSelection* selection = nullptr);

}  // namespace burin
