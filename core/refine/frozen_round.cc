#include "core/refine/frozen_round.h"

#include <algorithm>

#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

// Hands one problem's evaluation callback on to every term that has one.
class CallbackFanOut : public ceres::EvaluationCallback {
 public:
  explicit CallbackFanOut(const TermRounds& terms) {
    for (const auto& [term, round] : terms) {
      if (round->Callback() != nullptr) callbacks_.push_back(round->Callback());
    }
  }
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override {
    for (ceres::EvaluationCallback* callback : callbacks_) {
      callback->PrepareForEvaluation(evaluate_jacobians, new_evaluation_point);
    }
  }

 private:
  std::vector<ceres::EvaluationCallback*> callbacks_;
};

int64_t EvaluationCount(const TermRounds& terms) {
  int64_t count = 0;
  for (const auto& [term, round] : terms) count += round->EvaluationCount();
  return count;
}

}  // namespace

RoundProblem::RoundProblem(const TermRounds& terms, const RoundContext& context,
                           RoundParameters* parameters)
    : terms_(terms), energy_(parameters), callback_(std::make_unique<CallbackFanOut>(terms)) {
  task.energy = &energy_;
  task.vertices = &parameters->vertices;
  task.evaluation_callback = callback_.get();
  task.context = &context;
  ParallelInvoke(
      [&] {
        for (const auto& [term, round] : terms_) {
          energy_.BeginTerm(term->Name());
          round->AddBlocks(&energy_);
        }
      },
      [&] {
        for (const auto& [term, round] : terms_) round->FinishFreeze();
      });
}

void RoundProblem::SupportIsKnown() {
  const RoundContext& context = *task.context;
  for (const auto& [term, round] : terms_) round->SupportIsKnown();
  const auto vertex_count = static_cast<int>(task.vertices->size());
  lines_.reserve(vertex_count);  // their addresses stay
  for (const int v : energy_.Used()) {
    if (energy_.IsCamera(v)) {
      energy_.SetManifold(v, &pose_motion_);
      unknowns_ += pose_motion_.TangentSize();
    }
    if (v >= vertex_count) continue;
    if (context.normals[v].isZero() || context.moves[v] == 0) {
      energy_.SetConstant(v);
      continue;
    }
    unknowns_ += context.Unknowns(v);
    if (context.MovesAlongNormal(v)) {
      energy_.SetManifold(v, &lines_.emplace_back(context.normals[v]));
    }
  }
}

nlohmann::json RoundProblem::EnergyByTerm() const {
  task.evaluation_callback->PrepareForEvaluation(false, true);
  nlohmann::json energies = nlohmann::json::object();
  double total = 0;
  for (const auto& [term, round] : terms_) {
    if (energies.contains(term->Name())) continue;  // EnergyOf() is of all terms of that name
    const double energy = energy_.EnergyOf(term->Name());
    energies[term->Name()] = energy;
    total += energy;
  }
  energies["total"] = total;
  return energies;
}

int64_t RoundProblem::WindowCount() const {
  int64_t count = 0;
  for (const auto& [term, round] : terms_) count += round->WindowCount();
  return count;
}

RoundTrial RoundProblem::Try(const Strategy& strategy, const SolverOptions& options,
                             const std::vector<Eigen::Vector3d>& start,
                             const FrozenRound::OnProgress& on_progress) const {
  std::vector<Eigen::Vector3d>& vertices = *task.vertices;
  std::vector<CameraPose>& cameras = energy_.parameters().cameras;
  const std::vector<CameraPose> start_cameras = cameras;
  RoundTrial trial;
  std::copy(start.begin(), start.end(), vertices.begin());  // the addresses are the problem's
  trial.energy_initial = EnergyByTerm();
  trial.windows_initial = WindowCount();
  for (const auto& [term, round] : terms_) round->Forget();
  const int64_t evaluations_before = EvaluationCount(terms_);
  double paused_seconds = 0;
  Stopwatch watch;
  std::vector<Eigen::Vector3d> reported = start;  // by the last call with an accepted point
  const auto report = [&](const IterationRecord& record, double seconds, int64_t evaluations) {
    FrozenRound::Progress progress;
    progress.record = record;
    progress.record.seconds = seconds;
    progress.evaluations = evaluations;
    progress.vertices = &vertices;
    if (record.accepted) reported = vertices;
    return on_progress(progress);
  };
  SolveTask trial_task = task;
  trial_task.follow_vertices = true;
  trial_task.on_iteration = [&](const IterationRecord& record) {
    if (!on_progress) return true;
    const double now = watch.Seconds();
    IterationRecord copy = record;
    if (record.iteration == 0) copy.accepted = true;  // no step yet; strategies differ in the flag
    const bool go_on =
        report(copy, now - paused_seconds, EvaluationCount(terms_) - evaluations_before);
    paused_seconds += watch.Seconds() - now;
    return go_on;
  };
  trial.solve = strategy.solve(trial_task, options);
  trial.solve.strategy = strategy.name;
  trial.seconds = watch.Seconds() - paused_seconds;
  trial.evaluations = EvaluationCount(terms_) - evaluations_before;
  const auto go_back = [&] {  // the addresses stay
    std::copy(start.begin(), start.end(), vertices.begin());
    std::copy(start_cameras.begin(), start_cameras.end(), cameras.begin());
  };
  if (!trial.solve.usable) go_back();
  trial.energy_final = EnergyByTerm();
  trial.windows_final = WindowCount();
  if (on_progress && vertices != reported) {
    IterationRecord record;
    record.iteration = trial.solve.iterations;
    record.energy = trial.energy_final["total"];
    report(record, trial.seconds, trial.evaluations);
  }
  trial.vertices = vertices;
  trial.cameras = cameras;
  go_back();
  return trial;
}

const Strategy& StrategyFor(const std::string& name, int unknowns, const SolverOptions& options) {
  const Strategy* strategy = FindStrategy(name, unknowns, options);
  if (strategy == nullptr) throw InputError("solver.type = " + name + ": no such strategy");
  if (strategy->max_unknowns > 0 && unknowns > strategy->max_unknowns) {
    throw InputError("solver.type = " + strategy->name + ": " + std::to_string(unknowns) +
                     " unknowns, at most " + std::to_string(strategy->max_unknowns) +
                     " fit its dense matrix; take lbfgs");
  }
  return *strategy;
}

}  // namespace burin
