#include "apps/run/solver_comparison.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <sstream>

#include "core/support/did_you_mean.h"
#include "core/support/error.h"

namespace burin {
namespace {

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

// Errors of meshes to the truth, if there is one. The start of a round is the same mesh for every
// strategy and is measured once.
class ErrorGauge {
 public:
  ErrorGauge(const Truth* truth, const CompareOptions& options)
      : every_iteration_(options.error == ErrorMeasured::kEveryIteration) {
    if (truth != nullptr) meter_ = std::make_unique<AccuracyMeter>(*truth, options.evaluation);
  }
  bool every_iteration() const { return every_iteration_; }

  double Of(const FrozenRound& frozen, const std::vector<Eigen::Vector3d>& vertices) const {
    return meter_ == nullptr ? kNotMeasured : meter_->Measure(frozen.world_mesh(vertices)).rmse;
  }
  double OfStart(const FrozenRound& frozen) {
    if (meter_ == nullptr) return kNotMeasured;
    const std::vector<Eigen::Vector3d>& start = frozen.context->mesh->vertices;
    if (start != start_) {
      start_ = start;
      start_rmse_ = Of(frozen, start);
    }
    return start_rmse_;
  }

 private:
  std::unique_ptr<AccuracyMeter> meter_;
  bool every_iteration_;
  std::vector<Eigen::Vector3d> start_;
  double start_rmse_ = kNotMeasured;
};

// What strategies have used before the round at hand.
struct Used {
  int64_t evaluations = 0;
  double seconds = 0;
};

std::string TrialLine(const ComparedRound& round, const std::string& name) {
  std::ostringstream text;
  text << "level " << round.width << "x" << round.height << " round " << round.round + 1 << " "
       << name << ": ";
  if (!round.reason.empty()) {
    text << round.reason;
    return text.str();
  }
  text << round.trial.solve.iterations << " iterations, " << round.trial.evaluations
       << " evaluations, ";
  text.setf(std::ios::fixed);
  text.precision(2);
  text << round.trial.seconds << " s, energy ";
  text.unsetf(std::ios::fixed);
  text.precision(6);
  text << round.trial.energy_initial["total"].get<double>() << " -> "
       << round.trial.energy_final["total"].get<double>();
  if (std::isfinite(round.rmse)) text << ", RMSE " << round.rmse_start << " -> " << round.rmse;
  if (round.cameras > 0) text << ", cameras moved by " << round.trial.camera_px << " px";
  return text.str();
}

ComparedRound DescribedRound(const FrozenRound& frozen) {
  ComparedRound round;
  round.level = frozen.level;
  round.round = frozen.round;
  round.width = (*frozen.context->views)[0].camera.width;
  round.height = (*frozen.context->views)[0].camera.height;
  round.vertices = static_cast<int>(frozen.context->mesh->vertices.size());
  round.faces = static_cast<int>(frozen.context->mesh->faces.size());
  round.unknowns = frozen.unknowns;
  round.cameras = frozen.cameras;
  return round;
}

// Solves the round with a strategy; adds its rows to `rows` and returns its result with the vertices
// still in it. Exceptions of the strategy pass through.
ComparedRound Solve(const FrozenRound& frozen, const std::string& name, const Used& used,
                    ErrorGauge* gauge, std::vector<ComparisonRow>* rows) {
  ComparedRound round = DescribedRound(frozen);
  round.rmse_start = gauge->OfStart(frozen);
  const size_t first_row = rows->size();
  round.trial = frozen.solve(name, [&](const FrozenRound::Progress& progress) {
    const IterationRecord& record = progress.record;
    const bool at_start = rows->size() == first_row;
    const bool moved = record.accepted && !at_start;
    ComparisonRow row;
    row.strategy = name;
    row.level = frozen.level;
    row.round = frozen.round;
    row.iteration = record.iteration;
    row.evaluations = used.evaluations + progress.evaluations;
    row.seconds = used.seconds + record.seconds;
    row.accepted = record.accepted;
    row.energy = row.accepted ? record.energy : rows->back().energy;
    if (frozen.cameras > 0) row.camera_px = progress.camera_px;
    if (gauge->every_iteration()) {
      row.rmse = moved ? gauge->Of(frozen, *progress.vertices)
                       : (at_start ? round.rmse_start : rows->back().rmse);
    } else if (at_start) {
      row.rmse = round.rmse_start;
    }
    rows->push_back(row);
    return true;
  });
  if (!round.trial.solve.usable) {
    round.reason = "failed: " + round.trial.solve.termination;
    return round;
  }
  round.rmse = gauge->Of(frozen, round.trial.vertices);
  if (!gauge->every_iteration() && rows->size() > first_row) rows->back().rmse = round.rmse;
  return round;
}

// The same with exceptions kept as the reason.
ComparedRound TrySolve(const FrozenRound& frozen, const std::string& name, ErrorGauge* gauge,
                       std::vector<ComparisonRow>* rows) {
  ComparedRound failed = DescribedRound(frozen);
  try {
    return Solve(frozen, name, Used(), gauge, rows);
  } catch (const InputError& error) {
    failed.reason = std::string("refused: ") + error.what();
  } catch (const std::bad_alloc&) {
    failed.reason = "failed: out of memory";
  } catch (const std::exception& error) {
    failed.reason = std::string("failed: ") + error.what();
  }
  return failed;
}

void Evaluate(const TriangleMesh& mesh, const Truth* truth, const EvaluationOptions& options,
              ComparedStrategy* strategy) {
  if (truth == nullptr) return;
  strategy->evaluation = EvaluateMesh(mesh, *truth, options);
  strategy->evaluated = true;
}

void RunFrozen(const Scene& scene, const TriangleMesh& mesh, const PipelineOptions& pipeline,
               const Truth* truth, const std::function<void(const std::string&)>& say,
               Comparison* comparison) {
  ErrorGauge gauge(truth, comparison->options);
  const SolverOptions& solver = pipeline.refinement.solver;
  const LevelOptions& level = pipeline.refinement.level;
  std::vector<std::vector<ComparisonRow>> rows(comparison->strategies.size());
  PipelineParts parts;
  parts.selection = &comparison->selection;
  parts.measure_quality = false;
  parts.solve_round = [&](const FrozenRound& frozen) {
    const Strategy* reference = FindStrategy(solver.type, frozen.unknowns, solver);
    const bool last =
        frozen.level == level.finest && frozen.round == level.RoundsAt(level.finest) - 1;
    comparison->references.push_back(reference != nullptr ? reference->name : solver.type);
    RoundTrial next;
    bool have_next = false;
    for (size_t s = 0; s < rows.size(); ++s) {
      ComparedStrategy& strategy = comparison->strategies[s];
      ComparedRound round = TrySolve(frozen, strategy.name, &gauge, &rows[s]);
      say(TrialLine(round, strategy.name));
      if (last && round.reason.empty()) {
        Evaluate(frozen.world_mesh(round.trial.vertices), truth, comparison->options.evaluation,
                 &strategy);
      }
      if (strategy.name == comparison->references.back() && round.reason.empty()) {
        next = round.trial;
        have_next = true;
      }
      round.trial.vertices.clear();
      round.trial.vertices.shrink_to_fit();
      strategy.rounds.push_back(std::move(round));
    }
    return have_next ? next : frozen.solve(solver.type, nullptr);
  };
  RunPipeline(scene, mesh, pipeline, parts);
  for (std::vector<ComparisonRow>& of_strategy : rows) {
    comparison->rows.insert(comparison->rows.end(), of_strategy.begin(), of_strategy.end());
  }
}

void RunWhole(const Scene& scene, const TriangleMesh& mesh, const PipelineOptions& pipeline,
              const Truth* truth, const std::function<void(const std::string&)>& say,
              Comparison* comparison) {
  ErrorGauge gauge(truth, comparison->options);
  for (ComparedStrategy& strategy : comparison->strategies) {
    Used used;
    PipelineParts parts;
    parts.measure_quality = false;
    parts.selection = &comparison->selection;
    parts.solve_round = [&](const FrozenRound& frozen) {
      ComparedRound round = Solve(frozen, strategy.name, used, &gauge, &comparison->rows);
      say(TrialLine(round, strategy.name));
      used.evaluations += round.trial.evaluations;
      used.seconds += round.trial.seconds;
      RoundTrial trial = round.trial;
      round.trial.vertices.clear();
      round.trial.vertices.shrink_to_fit();
      strategy.rounds.push_back(std::move(round));
      return trial;
    };
    try {
      const PipelineResult result = RunPipeline(scene, mesh, pipeline, parts);
      Evaluate(result.mesh, truth, comparison->options.evaluation, &strategy);
    } catch (const InputError& error) {
      strategy.reason = std::string("refused: ") + error.what();
    } catch (const std::bad_alloc&) {
      strategy.reason = "failed: out of memory";
    } catch (const std::exception& error) {
      strategy.reason = std::string("failed: ") + error.what();
    }
    if (!strategy.reason.empty()) say(strategy.name + ": " + strategy.reason);
  }
}

}  // namespace

void CompareOptions::Describe(OptionSet* set) {
  set->Add(
      "compare.mode", &mode,
      "frozen = every strategy solves the same rounds, made by a run with solver.type; whole = "
      "each makes a whole run of its own");
  set->Add("compare.solvers", &solvers,
           "Strategies to compare, comma-separated (burin solvers lists them); empty = all");
  set->Add("compare.error", &error,
           "With a truth: error after every iteration, or at the start and end of a round only");
  evaluation.Describe(set);
}

std::vector<std::string> CompareOptions::Names() const {
  std::vector<std::string> known;
  for (const Strategy& strategy : Strategies()) known.push_back(strategy.name);
  if (solvers.empty()) return known;
  const std::vector<std::string> wanted = SplitAtCommas(solvers);
  for (const std::string& name : wanted) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw InputError("compare.solvers = " + solvers + ": '" + name + "' is not a strategy" +
                       DidYouMean(name, known) + "; burin solvers lists them");
    }
  }
  std::vector<std::string> names;
  for (const std::string& name : known) {
    if (std::find(wanted.begin(), wanted.end(), name) != wanted.end()) names.push_back(name);
  }
  return names;
}

bool Comparison::AnythingRan() const {
  for (const ComparedStrategy& strategy : strategies) {
    for (const ComparedRound& round : strategy.rounds) {
      if (round.reason.empty()) return true;
    }
  }
  return false;
}

Comparison CompareSolvers(const Scene& scene, const TriangleMesh& mesh,
                          const PipelineOptions& pipeline, const CompareOptions& options,
                          const Truth* truth, const std::function<void(const std::string&)>& say,
                          const PairSelection* selection) {
  pipeline.Check();
  Comparison comparison;
  comparison.options = options;
  comparison.has_truth = truth != nullptr;
  for (const std::string& name : options.Names()) {
    comparison.strategies.emplace_back();
    comparison.strategies.back().name = name;
  }
  if (truth != nullptr) comparison.before = EvaluateMesh(mesh, *truth, options.evaluation);
  comparison.selection =
      selection != nullptr ? *selection : SelectPairs(scene, mesh, pipeline.pairs);
  if (options.mode == CompareMode::kWhole) {
    RunWhole(scene, mesh, pipeline, truth, say, &comparison);
  } else {
    RunFrozen(scene, mesh, pipeline, truth, say, &comparison);
  }
  return comparison;
}

}  // namespace burin
