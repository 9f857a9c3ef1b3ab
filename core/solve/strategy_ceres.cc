// The strategies that are a configuration of ceres::Solve.
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/solve/ceres_problem.h"
#include "core/solve/conjugate_gradients.h"
#include "core/solve/strategies.h"

namespace burin {
namespace {

class IterationForwarder : public ceres::IterationCallback {
 public:
  // `min_step` ends the solve after a taken step with a smaller Euclidean norm; 0 = never.
  IterationForwarder(const SolveTask& task, double min_step) : task_(task), min_step_(min_step) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (!Report(summary)) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    const bool is_short =
        summary.iteration > 0 && summary.step_is_successful && summary.step_norm < min_step_;
    return is_short ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  bool Report(const ceres::IterationSummary& summary) const {
    if (!task_.on_iteration) return true;
    IterationRecord record;
    record.iteration = summary.iteration;
    record.energy = summary.cost;
    record.gradient_max = summary.gradient_max_norm;
    record.step_norm = summary.step_norm;
    record.accepted = summary.step_is_successful;
    record.linear_iterations = summary.linear_solver_iterations;
    record.seconds = summary.cumulative_time_in_seconds;
    return task_.on_iteration(record);
  }

  const SolveTask& task_;
  double min_step_;
};

// Evaluation and linear algebra run on one thread inside Ceres, whose sums over residual blocks
// would otherwise depend on scheduling; the parallel work is in the photometric energy's callback.
ceres::Solver::Options CommonOptions(const SolverOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.num_threads = 1;
  ceres_options.logging_type = ceres::SILENT;
  return ceres_options;
}

SolveSummary RunCeres(const SolveTask& task, const SolverOptions& solver,
                      ceres::Solver::Options options, double min_step = 0) {
  IterationForwarder forwarder(task, min_step);
  options.callbacks.push_back(&forwarder);
  options.update_state_every_iteration = task.follow_vertices;
  ceres::Solver::Summary ceres_summary;
  std::optional<CameraUnits> units;  // outlive the problem
  CeresProblem problem(*task.energy, task.evaluation_callback);
  if (task.energy->CameraCount() > 0) {
    units.emplace(*task.energy, task.evaluation_callback, solver.camera_damping);
    problem.MoveCamerasIn(*units);
  }
  ceres::Solve(options, problem.get(), &ceres_summary);
  SolveSummary summary;
  summary.usable = ceres_summary.IsSolutionUsable();
  summary.initial_energy = ceres_summary.initial_cost;
  summary.final_energy = ceres_summary.final_cost;
  summary.iterations = std::max(0, static_cast<int>(ceres_summary.iterations.size()) - 1);
  summary.unknowns = ceres_summary.num_effective_parameters_reduced;
  summary.linear_solver_seconds = ceres_summary.linear_solver_time_in_seconds;
  summary.termination = ceres_summary.message;
  return summary;
}

SolveSummary LineSearch(const SolveTask& task, const SolverOptions& options,
                        ceres::LineSearchDirectionType direction, ceres::LineSearchType search) {
  ceres::Solver::Options ceres_options = CommonOptions(options);
  ceres_options.minimizer_type = ceres::LINE_SEARCH;
  ceres_options.line_search_direction_type = direction;
  ceres_options.line_search_type = search;
  return RunCeres(task, options, ceres_options);
}

SolveSummary TrustRegion(const SolveTask& task, const SolverOptions& options,
                         ceres::LinearSolverType linear_solver,
                         ceres::TrustRegionStrategyType strategy) {
  ceres::Solver::Options ceres_options = CommonOptions(options);
  ceres_options.minimizer_type = ceres::TRUST_REGION;
  ceres_options.linear_solver_type = linear_solver;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  ceres_options.preconditioner_type = ceres::JACOBI;
  ceres_options.trust_region_strategy_type = strategy;
  ceres_options.initial_trust_region_radius = options.initial_trust_radius;
  const bool joint = task.energy->CameraCount() > 0;
  ceres_options.max_linear_solver_iterations =
      joint ? std::max(options.cg_max_iterations, kJointIterations) : options.cg_max_iterations;
  ceres_options.eta =
      joint ? std::min(options.cg_tolerance, kJointTolerance) : options.cg_tolerance;
  const auto moving = static_cast<double>(task.energy->Moving().size());
  return RunCeres(task, options, ceres_options,
                  options.min_step_px * task.pixel * std::sqrt(moving));
}

}  // namespace

SolveSummary SolveSteepestDescent(const SolveTask& task, const SolverOptions& options) {
  return LineSearch(task, options, ceres::STEEPEST_DESCENT, ceres::ARMIJO);
}

SolveSummary SolveNcg(const SolveTask& task, const SolverOptions& options) {
  return LineSearch(task, options, ceres::NONLINEAR_CONJUGATE_GRADIENT, ceres::WOLFE);
}

SolveSummary SolveBfgs(const SolveTask& task, const SolverOptions& options) {
  return LineSearch(task, options, ceres::BFGS, ceres::WOLFE);
}

SolveSummary SolveLbfgs(const SolveTask& task, const SolverOptions& options) {
  return LineSearch(task, options, ceres::LBFGS, ceres::WOLFE);
}

SolveSummary SolveLmCholesky(const SolveTask& task, const SolverOptions& options) {
  return TrustRegion(task, options, ceres::SPARSE_NORMAL_CHOLESKY, ceres::LEVENBERG_MARQUARDT);
}

SolveSummary SolveLmCgnr(const SolveTask& task, const SolverOptions& options) {
  return TrustRegion(task, options, ceres::CGNR, ceres::LEVENBERG_MARQUARDT);
}

SolveSummary SolveDogleg(const SolveTask& task, const SolverOptions& options) {
  return TrustRegion(task, options, ceres::SPARSE_NORMAL_CHOLESKY, ceres::DOGLEG);
}

}  // namespace burin
