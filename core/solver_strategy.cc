#include "core/solver_strategy.h"

#include <ceres/cost_function.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace burin {
namespace {

class IterationForwarder : public ceres::IterationCallback {
 public:
  explicit IterationForwarder(const SolveTask& task) : task_(task) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (!task_.on_iteration) return ceres::SOLVER_CONTINUE;
    IterationRecord record;
    record.iteration = summary.iteration;
    record.energy = summary.cost;
    record.gradient_max = summary.gradient_max_norm;
    record.step_norm = summary.step_norm;
    record.accepted = summary.step_is_successful;
    record.linear_iterations = summary.linear_solver_iterations;
    record.seconds = summary.cumulative_time_in_seconds;
    return task_.on_iteration(record) ? ceres::SOLVER_CONTINUE
                                      : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const SolveTask& task_;
};

// Evaluation and linear algebra run on one thread inside Ceres, whose sums over residual blocks
// would otherwise depend on scheduling; the parallel work is in the photometric energy's callback.
ceres::Solver::Options CommonOptions(const SolverOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.num_threads = 1;
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.update_state_every_iteration = false;
  return ceres_options;
}

SolveSummary RunCeres(const SolveTask& task, ceres::Solver::Options options) {
  IterationForwarder forwarder(task);
  options.callbacks.push_back(&forwarder);
  options.update_state_every_iteration = task.follow_vertices;
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(options, task.problem, &ceres_summary);
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
  return RunCeres(task, ceres_options);
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
  ceres_options.max_linear_solver_iterations = options.cg_max_iterations;
  ceres_options.eta = options.cg_tolerance;
  return RunCeres(task, ceres_options);
}

// 1/2 |r|^2 of residual blocks whose terms have no evaluation callback, at their present parameters.
double EnergyOfBlocks(const ceres::Problem& problem,
                      const std::vector<ceres::ResidualBlockId>& blocks) {
  double energy = 0;
  std::vector<double*> parameters;
  std::vector<double> residuals;
  for (const ceres::ResidualBlockId block : blocks) {
    const ceres::CostFunction* cost = problem.GetCostFunctionForResidualBlock(block);
    problem.GetParameterBlocksForResidualBlock(block, &parameters);
    residuals.resize(cost->num_residuals());
    cost->Evaluate(parameters.data(), residuals.data(), nullptr);
    for (const double r : residuals) energy += 0.5 * r * r;
  }
  return energy;
}

// The paper's minimiser: V <- V - step * dE_photo/dV, then V <- V + umbrella_step * (neighbours'
// mean - V). The step is fixed for the round so that the 99th percentile of the first move is
// gradient_step_px footprints. Smoothness residuals of the problem are not used: the umbrella step
// stands for them; records have their energy in, to be compared with those of other strategies.
SolveSummary GradientDescent(const SolveTask& task, const SolverOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<Eigen::Vector3d>& vertices = *task.vertices;
  ceres::Problem::EvaluateOptions evaluate;
  std::vector<ceres::ResidualBlockId> smoothness_blocks;
  for (const auto& [name, blocks] : task.term_blocks) {
    std::vector<ceres::ResidualBlockId>& group =
        name == "smoothness" ? smoothness_blocks : evaluate.residual_blocks;
    group.insert(group.end(), blocks.begin(), blocks.end());
  }
  std::vector<int> moving;
  for (size_t v = 0; v < vertices.size(); ++v) {
    double* block = vertices[v].data();
    if (!task.problem->HasParameterBlock(block)) continue;
    if (task.problem->IsParameterBlockConstant(block)) continue;
    moving.push_back(static_cast<int>(v));
    evaluate.parameter_blocks.push_back(block);
  }
  const bool along_normal = task.context->motion == Motion::kNormal;
  SolveSummary summary;
  summary.unknowns = static_cast<int>(moving.size()) * (along_normal ? 1 : 3);
  summary.termination = "Maximum number of iterations reached.";
  std::vector<Eigen::Vector3d> best = vertices;
  double step = 0;
  std::vector<double> gradient;
  for (int iteration = 0;; ++iteration) {
    double energy = 0;
    if (!task.problem->Evaluate(evaluate, &energy, nullptr, &gradient, nullptr) ||
        !std::isfinite(energy)) {
      summary.termination = "Evaluation failed.";
      break;
    }
    if (iteration == 0) summary.initial_energy = energy;
    if (iteration == 0 || energy < summary.final_energy) {
      summary.final_energy = energy;
      best = vertices;
    }
    summary.usable = true;
    summary.iterations = iteration;
    std::vector<double> magnitude(moving.size());
    for (size_t m = 0; m < moving.size(); ++m) {
      magnitude[m] = along_normal ? std::abs(gradient[m])
                                  : Eigen::Map<const Eigen::Vector3d>(&gradient[3 * m]).norm();
    }
    IterationRecord record;
    record.iteration = iteration;
    record.energy = energy + EnergyOfBlocks(*task.problem, smoothness_blocks);
    for (double m : magnitude) record.gradient_max = std::max(record.gradient_max, m);
    if (iteration == 0 && !magnitude.empty()) {
      const size_t rank = magnitude.size() * 99 / 100;
      std::nth_element(magnitude.begin(), magnitude.begin() + static_cast<long>(rank),
                       magnitude.end());
      step = magnitude[rank] > 0 ? options.gradient_step_px / magnitude[rank] : 0;
    }
    record.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (task.on_iteration && !task.on_iteration(record)) {
      summary.termination = "Stopped by the caller.";
      break;
    }
    if (iteration >= options.max_iterations) break;
    for (size_t m = 0; m < moving.size(); ++m) {
      const int v = moving[m];
      if (along_normal) {
        vertices[v] -= step * gradient[m] * task.context->normals[v];
      } else {
        vertices[v] -= step * Eigen::Map<const Eigen::Vector3d>(&gradient[3 * m]);
      }
    }
    const std::vector<Eigen::Vector3d> before = vertices;
    const Adjacency& neighbors = task.context->neighbors;
    for (int v : moving) {
      if (task.context->boundary[v] != 0) continue;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const int* n = neighbors.Begin(v); n != neighbors.End(v); ++n) mean += before[*n];
      Eigen::Vector3d move = options.umbrella_step * (mean / neighbors.Degree(v) - before[v]);
      if (along_normal) {
        move = task.context->normals[v] * task.context->normals[v].dot(move);
      }
      vertices[v] += move;
    }
  }
  vertices = best;
  return summary;
}

SolveSummary WithName(SolveSummary summary, const std::string& name) {
  summary.strategy = name;
  return summary;
}

}  // namespace

void SolverOptions::Describe(OptionSet* set) {
  std::vector<std::string> names = {"auto"};
  for (const Strategy& strategy : Strategies()) names.push_back(strategy.name);
  set->Add("solver.type", &type, "Minimiser; auto = lm_cholesky for small meshes, else lm_cgnr",
           names);
  set->Add("solver.max_iterations", &max_iterations, "Iterations a round at most", 0, 100000);
  set->Add("solver.function_tolerance", &function_tolerance,
           "A round ends when |dE| < function_tolerance * E", 0, 1);
  set->Add("solver.cholesky_max_unknowns", &cholesky_max_unknowns,
           "auto takes lm_cholesky up to this many unknowns", 0, 1e9);
  set->Add("solver.cg_max_iterations", &cg_max_iterations,
           "Conjugate-gradient iterations a step at most (lm_cgnr)", 1, 100000);
  set->Add("solver.cg_tolerance", &cg_tolerance,
           "Relative accuracy of the truncated Newton step (lm_cgnr)", 1e-12, 1);
  set->Add("solver.initial_trust_radius", &initial_trust_radius,
           "Initial trust-region radius in Ceres' scaling (lm_*, dogleg)", 1e-12, 1e32);
  set->Add("solver.gradient_step_px", &gradient_step_px,
           "99th percentile of the first move, pixel footprints (gradient_descent)", 1e-9, 1000);
  set->Add("solver.umbrella_step", &umbrella_step,
           "Share of the way to the neighbours' mean a step (gradient_descent)", 0, 1);
}

const std::vector<Strategy>& Strategies() {
  using ceres::ARMIJO;
  using ceres::WOLFE;
  static const auto* table = new std::vector<Strategy>{
      {"gradient_descent", "fixed step and umbrella step, as in the paper",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(GradientDescent(task, options), "gradient_descent");
       }},
      {"steepest_descent", "steepest descent with Armijo line search",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(LineSearch(task, options, ceres::STEEPEST_DESCENT, ARMIJO),
                         "steepest_descent");
       }},
      {"ncg", "nonlinear conjugate gradients (Fletcher-Reeves) with Wolfe line search",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(LineSearch(task, options, ceres::NONLINEAR_CONJUGATE_GRADIENT, WOLFE),
                         "ncg");
       }},
      {"bfgs", "BFGS with a dense inverse Hessian; small meshes only",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(LineSearch(task, options, ceres::BFGS, WOLFE), "bfgs");
       }},
      {"lbfgs", "L-BFGS with Wolfe line search",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(LineSearch(task, options, ceres::LBFGS, WOLFE), "lbfgs");
       }},
      {"lm_cholesky", "Levenberg-Marquardt, sparse Cholesky on SuiteSparse",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(
             TrustRegion(task, options, ceres::SPARSE_NORMAL_CHOLESKY, ceres::LEVENBERG_MARQUARDT),
             "lm_cholesky");
       }},
      {"lm_cgnr",
       "Levenberg-Marquardt, conjugate gradients with Jacobi preconditioner; large meshes",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(TrustRegion(task, options, ceres::CGNR, ceres::LEVENBERG_MARQUARDT),
                         "lm_cgnr");
       }},
      {"dogleg", "Powell's dogleg, sparse Cholesky on SuiteSparse",
       [](const SolveTask& task, const SolverOptions& options) {
         return WithName(TrustRegion(task, options, ceres::SPARSE_NORMAL_CHOLESKY, ceres::DOGLEG),
                         "dogleg");
       }},
  };
  return *table;
}

const Strategy* FindStrategy(const std::string& name, int unknowns, const SolverOptions& options) {
  const std::string wanted =
      name != "auto" ? name
                     : (unknowns <= options.cholesky_max_unknowns ? "lm_cholesky" : "lm_cgnr");
  for (const Strategy& strategy : Strategies()) {
    if (strategy.name == wanted) return &strategy;
  }
  return nullptr;
}

}  // namespace burin
