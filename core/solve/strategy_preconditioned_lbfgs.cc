// L-BFGS in other variables. With M = P^T L L^T P symmetric positive definite and x0 the start of
// the round,
//
//   x = x0 + P^T L^-T y / c,   dE/dy = L^-1 P g / c
//
// L-BFGS over y is L-BFGS over x whose first inverse Hessian is M^-1 / c^2 instead of the identity.
//
//   lbfgs_sobolev   M = I + length^2 K, K the Laplacian of the mesh graph (degree on the diagonal,
//                   -1 for every edge between moving vertices): gradients are smoothed over about
//                   `length` edges, solver.sobolev_length
//   lbfgs_h         M = H + diag(H) / radius + 0.01 mean(diag(H)) I at the start, radius being
//                   solver.initial_trust_radius: the first direction is nearly a
//                   Levenberg-Marquardt step
//
// Cameras that move have their part of H's diagonal for M, for lbfgs_sobolev in units of the vertices' mean.
//
// c makes step 1 along the first direction p = -M^-1 g the minimum of the model with H: with
// alpha = -g.p / p.H p, c^2 = 1 / alpha (and larger where the line search would take less than a
// full first step). Factor and ordering are made once a round by CHOLMOD and used at every
// evaluation. Constant blocks have no unknowns and stay. Each coordinate has its own copy of the
// graph with motion.type free.
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <cmath>

#include "core/solve/normal_equations.h"
#include "core/solve/sparse_cholesky.h"
#include "core/solve/strategies.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

// Unknowns that H hardly holds may move far along L-BFGS' directions, whose gradients are from other
// points than H; this share of the mean diagonal is to hold them. It is not tuned: see
// docs/solver_study.md, where rounding alone changes the result by more than 0 or 0.1 here does.
constexpr double kMeanDamping = 0.01;
constexpr double kNoCurvature = 1e-12;

// H's diagonal at the unknowns of cameras; no zeros.
Eigen::VectorXd CameraDiagonal(const NormalEquations& equations) {
  const Eigen::VectorXd diagonal = equations.border().curvature().diagonal();
  if (diagonal.size() == 0) return diagonal;
  return diagonal.array().max(kMeanDamping * diagonal.mean() + kNoCurvature);
}

// A matrix of more unknowns, with `diagonal` for these.
SymmetricMatrix WithDiagonal(SymmetricMatrix matrix, const Eigen::VectorXd& diagonal) {
  for (const double entry : diagonal) {
    matrix.diagonal.push_back(static_cast<int64_t>(matrix.column.size()));
    matrix.column.push_back(matrix.size++);
    matrix.value.push_back(entry);
    matrix.start.push_back(static_cast<int64_t>(matrix.column.size()));
  }
  return matrix;
}

// I + length^2 K in the unknowns of `equations` that are not cameras'.
SymmetricMatrix SobolevMatrix(const NormalEquations& equations, const SolveTask& task,
                              double length) {
  const std::vector<NormalEquations::MovingBlock>& blocks = equations.moving_blocks();
  const auto vertex_count = static_cast<int>(task.vertices->size());
  std::vector<int> moving_of(vertex_count, -1);  // of a vertex, into `blocks`
  for (size_t k = 0; k < blocks.size(); ++k) {
    if (blocks[k].parameter < vertex_count) moving_of[blocks[k].parameter] = static_cast<int>(k);
  }
  SymmetricMatrix matrix;
  matrix.size = equations.matrix().size;
  matrix.start.push_back(0);
  std::vector<int> neighbors;
  for (size_t k = 0; k < blocks.size() && blocks[k].first_unknown < matrix.size; ++k) {
    neighbors.clear();
    const int v = blocks[k].parameter;
    if (v < vertex_count) {
      const Adjacency& graph = task.context->neighbors;
      for (const int* n = graph.Begin(v); n != graph.End(v); ++n) {
        if (moving_of[*n] >= 0) neighbors.push_back(moving_of[*n]);
      }
      neighbors.push_back(static_cast<int>(k));
      std::sort(neighbors.begin(), neighbors.end());
    } else {
      neighbors.push_back(static_cast<int>(k));
    }
    const double degree = static_cast<double>(neighbors.size()) - 1;
    for (int i = 0; i < blocks[k].tangent_size; ++i) {
      for (int n : neighbors) {
        if (n == static_cast<int>(k)) {
          matrix.diagonal.push_back(static_cast<int64_t>(matrix.column.size()));
          matrix.value.push_back(1 + length * length * degree);
        } else {
          matrix.value.push_back(-length * length);
        }
        matrix.column.push_back(blocks[n].first_unknown + i);
      }
      matrix.start.push_back(static_cast<int64_t>(matrix.column.size()));
    }
  }
  return matrix;
}

class ChangedVariables : public ceres::FirstOrderFunction {
 public:
  // Both must outlive this.
  ChangedVariables(NormalEquations* equations, SparseCholesky* factor)
      : equations_(equations), factor_(factor) {
    equations_->Save(&start_);
  }
  void SetScale(double c) { scale_ = c; }

  int NumParameters() const override { return equations_->unknowns(); }

  bool Evaluate(const double* y, double* cost, double* gradient) const override {
    if (!Move(y)) return false;
    if (gradient == nullptr) return equations_->EvaluateCost(cost);
    if (!equations_->EvaluateGradient(cost, &gradient_)) return false;
    factor_->ApplyInverseLower(gradient_, &changed_);
    Eigen::Map<Eigen::VectorXd>(gradient, changed_.size()) = changed_ / scale_;
    return true;
  }

  // Sets the parameter blocks to x(y).
  bool Move(const double* y) const {
    Displacement(y, &displacement_);
    return equations_->SetPlus(start_, displacement_);
  }
  void Displacement(const double* y, Eigen::VectorXd* result) const {
    const Eigen::Map<const Eigen::VectorXd> map(y, NumParameters());
    factor_->ApplyInverseUpper(map / scale_, result);
  }
  // dE/dx of the last evaluation.
  const Eigen::VectorXd& gradient() const { return gradient_; }
  void Restore() { equations_->Restore(start_); }

 private:
  NormalEquations* equations_;
  SparseCholesky* factor_;
  NormalEquations::State start_;
  double scale_ = 1;
  mutable Eigen::VectorXd displacement_;
  mutable Eigen::VectorXd gradient_;
  mutable Eigen::VectorXd changed_;
};

// gradient_max is of the last point that the line search evaluated, mostly the accepted one.
class Forwarder : public ceres::IterationCallback {
 public:
  Forwarder(const SolveTask& task, const ChangedVariables& function, const double* y)
      : task_(task), function_(function), y_(y) {
    function_.Displacement(y_, &before_);
  }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (!task_.on_iteration) return ceres::SOLVER_CONTINUE;
    Eigen::VectorXd now;
    function_.Displacement(y_, &now);
    IterationRecord record;
    record.iteration = summary.iteration;
    record.energy = summary.cost;
    record.gradient_max = function_.gradient().lpNorm<Eigen::Infinity>();
    record.step_norm = (now - before_).norm();
    record.accepted = summary.step_is_successful;
    record.seconds = watch_.Seconds();
    before_ = now;
    if (task_.follow_vertices) function_.Move(y_);
    return task_.on_iteration(record) ? ceres::SOLVER_CONTINUE
                                      : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const SolveTask& task_;
  const ChangedVariables& function_;
  const double* y_;
  Eigen::VectorXd before_;
  const Stopwatch watch_;
};

SolveSummary Failed(SolveSummary summary, const std::string& why) {
  summary.usable = false;
  summary.termination = why;
  return summary;
}

// make_factor(equations, &factor) factors M; the equations are evaluated at the start.
template <typename MakeFactor>
SolveSummary Minimise(const SolveTask& task, const SolverOptions& options,
                      const MakeFactor& make_factor) {
  NormalEquations equations(*task.energy, task.evaluation_callback);
  SolveSummary summary;
  summary.unknowns = equations.unknowns();
  Eigen::VectorXd gradient;
  if (!equations.Evaluate(&summary.initial_energy, &gradient)) {
    return Failed(summary, "Evaluation failed at the start.");
  }
  summary.final_energy = summary.initial_energy;
  summary.usable = true;
  if (equations.unknowns() == 0) {
    summary.termination = "Nothing moves.";
    return summary;
  }
  const Stopwatch watch;
  SparseCholesky factor;
  if (!make_factor(equations, &factor)) return Failed(summary, "Factorisation failed.");
  Eigen::VectorXd changed;
  factor.ApplyInverseLower(gradient, &changed);
  Eigen::VectorXd direction;
  factor.ApplyInverseUpper(changed, &direction);
  Eigen::VectorXd product;
  equations.Multiply(direction, Eigen::VectorXd(), &product);
  const double curvature = direction.dot(product);
  summary.linear_solver_seconds = watch.Seconds();
  // Ceres' first step along -dE/dy is min(1, 1 / |dE/dy|_max); it is to be `alpha` in the unscaled
  // variables: min(1, c / G) / c^2 = alpha with G = |L^-1 P g|_max.
  const double alpha = curvature > 0 ? changed.squaredNorm() / curvature : 1;
  const double largest = changed.lpNorm<Eigen::Infinity>();
  const double root = 1 / std::sqrt(alpha);
  auto* function = new ChangedVariables(&equations, &factor);
  function->SetScale(largest <= root || largest == 0 ? root : 1 / (alpha * largest));

  const ceres::GradientProblem problem(function);  // owns it
  std::vector<double> y(equations.unknowns(), 0.0);
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::LBFGS;
  solver.line_search_type = ceres::WOLFE;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.logging_type = ceres::SILENT;
  solver.update_state_every_iteration = true;
  Forwarder forwarder(task, *function, y.data());
  solver.callbacks.push_back(&forwarder);
  ceres::GradientProblemSolver::Summary ceres_summary;
  ceres::Solve(solver, problem, y.data(), &ceres_summary);
  summary.termination = ceres_summary.message;
  summary.iterations = std::max(0, static_cast<int>(ceres_summary.iterations.size()) - 1);
  if (!ceres_summary.IsSolutionUsable() || !(ceres_summary.final_cost <= summary.initial_energy) ||
      !function->Move(y.data())) {
    function->Restore();
    return summary;
  }
  summary.final_energy = ceres_summary.final_cost;
  return summary;
}

}  // namespace

SolveSummary SolveLbfgsSobolev(const SolveTask& task, const SolverOptions& options) {
  return Minimise(task, options, [&](const NormalEquations& equations, SparseCholesky* factor) {
    const double mean = equations.matrix().Diagonal().mean() + kNoCurvature;
    const SymmetricMatrix matrix = WithDiagonal(
        SobolevMatrix(equations, task, options.sobolev_length), CameraDiagonal(equations) / mean);
    return factor->Factor(matrix, Eigen::VectorXd::Zero(matrix.size));
  });
}

SolveSummary SolveLbfgsH(const SolveTask& task, const SolverOptions& options) {
  return Minimise(task, options, [&](const NormalEquations& equations, SparseCholesky* factor) {
    const Eigen::VectorXd cameras = CameraDiagonal(equations);
    const Eigen::VectorXd diagonal = equations.matrix().Diagonal();
    const double mean_damping = kMeanDamping * diagonal.mean();
    Eigen::VectorXd damping(equations.unknowns());
    damping << (diagonal.array() / options.initial_trust_radius + mean_damping).matrix(),
        kMeanDamping * cameras;
    if (cameras.size() == 0) return factor->Factor(equations.matrix(), damping);
    return factor->Factor(WithDiagonal(equations.matrix(), cameras), damping);
  });
}

}  // namespace burin
