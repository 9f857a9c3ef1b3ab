// Levenberg-Marquardt on burin's own normal equations, every step by preconditioned conjugate
// gradients:
//
//   (H + D / radius) s = -g,    D_i = clamp(c_i^2 H_ii, 1e-6, 1e32) / c_i^2,
//   c_i = 1 / (1 + sqrt(H_ii)) at the start of the solve
//   rho = (E(x) - E(x + s)) / -(g.s + 1/2 s.H s)        a step is taken when rho > 1e-3
//   taken:    radius /= max(1/3, 1 - (2 rho - 1)^3), at most 1e16
//   rejected: radius /= 2, then 4, 8, ... until a step is taken
//
// (Nielsen 1999; scaling, constants and stopping test are those of Ceres, so that the solver.*
// options mean the same). Cameras that move are unknowns of the same steps (core/solve/camera_border.h): D has
// solver.camera_damping times the median over the cameras beside theirs. Different from Ceres: the last step, whose |dE| ends the solve, is kept
// when it lowers E; H is assembled (core/solve/normal_equations.h); everything uses all threads and has
// the same bytes for any number of them.
#include <algorithm>
#include <cmath>

#include "core/solve/conjugate_gradients.h"
#include "core/solve/normal_equations.h"
#include "core/solve/strategies.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

constexpr double kMinDiagonal = 1e-6;
constexpr double kMaxDiagonal = 1e32;
constexpr double kMinRho = 1e-3;
constexpr double kMaxRadius = 1e16;
constexpr double kMinRadius = 1e-32;
constexpr double kGradientTolerance = 1e-10;
constexpr int kSchurTries = 6;

class LmPcg {
 public:
  LmPcg(const SolveTask& task, const SolverOptions& options)
      : task_(task), options_(options), equations_(*task.energy, task.evaluation_callback) {
    for (const NormalEquations::MovingBlock& block : equations_.moving_blocks()) {
      if (block.first_unknown >= equations_.matrix().size) break;  // cameras
      first_.push_back(block.first_unknown);
    }
    first_.push_back(equations_.matrix().size);
  }
  SolveSummary Solve();

 private:
  // Fills step_; returns the decrease of E that the model predicts.
  double ComputeStep();
  void SolveSurface(const Eigen::VectorXd& damping);
  void SolveJoint(Eigen::VectorXd damping);
  // Euclidean norm of step_, a camera's part in the unit in which its curvature is the mean of the vertices' (as
  // core/solve/camera_units.h).
  double StepNorm() const;
  // The same as RMS over the vertices, in pixels of the level.
  double StepPixels() const;
  // Back to the last accepted point.
  bool Return(const NormalEquations::State& state);
  // False: stop.
  bool Report(int iteration, bool accepted);

  const SolveTask& task_;
  const SolverOptions& options_;
  const Stopwatch watch_;
  NormalEquations equations_;
  std::vector<int> first_;  // unknown of each moving block but cameras, and the end
  BlockJacobi preconditioner_;
  double cost_ = 0;
  double radius_ = 0;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd scale_squared_;
  Eigen::VectorXd step_;
  int linear_iterations_ = 0;
  SolveSummary summary_;
};

double LmPcg::ComputeStep() {
  const Stopwatch watch;
  const Eigen::VectorXd diagonal = equations_.Diagonal();
  if (scale_squared_.size() == 0) {
    scale_squared_ = (1 + diagonal.array().sqrt()).square().inverse();
  }
  const Eigen::VectorXd damping =
      (diagonal.array() * scale_squared_.array()).max(kMinDiagonal).min(kMaxDiagonal) /
      (scale_squared_.array() * radius_);
  if (equations_.border().empty()) {
    SolveSurface(damping);
  } else {
    SolveJoint(damping);
  }
  Eigen::VectorXd product;
  equations_.Multiply(step_, Eigen::VectorXd(), &product);
  const double decrease = -(Dot(gradient_, step_) + 0.5 * Dot(step_, product));
  summary_.linear_solver_seconds += watch.Seconds();
  return decrease;
}

void LmPcg::SolveSurface(const Eigen::VectorXd& damping) {
  preconditioner_.Factor(equations_.matrix(), damping, first_);
  ConjugateGradientOptions cg;
  cg.max_iterations = options_.cg_max_iterations;
  cg.tolerance = options_.cg_tolerance;
  linear_iterations_ =
      ConjugateGradients(equations_.matrix(), damping, preconditioner_, -gradient_, cg, &step_);
}

void LmPcg::SolveJoint(Eigen::VectorXd damping) {
  CameraBorder* border = equations_.mutable_border();
  const int rows = equations_.matrix().size;
  damping.tail(border->unknowns()) += options_.camera_damping * border->MedianDiagonal();
  preconditioner_.FactorMajorant(equations_.matrix(), damping.head(rows), first_);
  // Rounding may leave a direction of no curvature below zero.
  for (int tries = 0; tries < kSchurTries; ++tries) {
    if (border->Factor(preconditioner_, damping.tail(border->unknowns()))) break;
    damping.tail(border->unknowns()) *= 10;
  }
  ConjugateGradientOptions cg;
  cg.max_iterations = std::max(options_.cg_max_iterations, kJointIterations);
  cg.tolerance = std::min(options_.cg_tolerance, kJointTolerance);
  linear_iterations_ = ConjugateGradients(
      [&](const Eigen::VectorXd& p, Eigen::VectorXd* product) {
        equations_.Multiply(p, damping, product);
      },
      [&](const Eigen::VectorXd& r, Eigen::VectorXd* z) {
        border->ApplyInverse(preconditioner_, r, z);
      },
      -gradient_, cg, &step_);
}

double LmPcg::StepNorm() const {
  const Eigen::VectorXd of_surface = step_.head(equations_.matrix().size);
  double squares = Dot(of_surface, of_surface);
  if (!equations_.border().empty()) {
    const Eigen::VectorXd of_cameras = step_.tail(equations_.border().unknowns());
    const Eigen::VectorXd diagonal = equations_.matrix().Diagonal();
    const double mean = diagonal.size() > 0 ? diagonal.mean() : 1;
    const double energy = of_cameras.dot(equations_.border().curvature() * of_cameras);
    if (mean > 0) squares += energy / mean;
  }
  return std::sqrt(squares);
}

double LmPcg::StepPixels() const {
  const double moving = std::max<double>(1, static_cast<double>(first_.size()) - 1);
  return StepNorm() / (std::sqrt(moving) * task_.pixel);
}

bool LmPcg::Return(const NormalEquations::State& state) {
  equations_.Restore(state);
  // What couples vertices and cameras is of the last evaluation (core/solve/energy_blocks.h).
  return equations_.border().empty() || equations_.Evaluate(&cost_, &gradient_);
}

bool LmPcg::Report(int iteration, bool accepted) {
  summary_.iterations = iteration;
  summary_.final_energy = cost_;
  if (!task_.on_iteration) return true;
  IterationRecord record;
  record.iteration = iteration;
  record.energy = cost_;
  record.gradient_max = gradient_.lpNorm<Eigen::Infinity>();
  record.step_norm = step_.size() > 0 ? StepNorm() : 0;
  record.accepted = accepted;
  record.linear_iterations = linear_iterations_;
  record.seconds = watch_.Seconds();
  if (task_.on_iteration(record)) return true;
  summary_.termination = "Stopped by the caller.";
  return false;
}

SolveSummary LmPcg::Solve() {
  summary_.unknowns = equations_.unknowns();
  if (!equations_.Evaluate(&cost_, &gradient_)) {
    summary_.termination = "Evaluation failed at the start.";
    return summary_;
  }
  summary_.usable = true;
  summary_.initial_energy = cost_;
  if (!Report(0, true)) return summary_;
  NormalEquations::State state;
  equations_.Save(&state);
  radius_ = options_.initial_trust_radius;
  double shrink = 2;
  for (int iteration = 1;; ++iteration) {
    if (iteration > options_.max_iterations) {
      summary_.termination = "Maximum number of iterations reached.";
      return summary_;
    }
    if (gradient_.lpNorm<Eigen::Infinity>() <= kGradientTolerance) {
      summary_.termination = "Gradient tolerance reached.";
      return summary_;
    }
    const double predicted = ComputeStep();
    const double step_px = StepPixels();
    if (step_px < options_.min_step_px) {
      summary_.termination =
          "Next step of " + std::to_string(step_px) + " px is shorter than solver.min_step_px.";
      return summary_;
    }
    double trial = 0;
    const bool valid =
        predicted > 0 && equations_.SetPlus(state, step_) && equations_.EvaluateCost(&trial);
    const double change = cost_ - trial;
    const bool converged = valid && std::abs(change) <= options_.function_tolerance * cost_;
    const double rho = valid ? change / predicted : 0;
    if (valid && (rho > kMinRho || (converged && change > 0))) {
      // The evaluation callback has the derivatives at this point already.
      const bool last = converged || iteration == options_.max_iterations;
      const bool evaluated = last ? equations_.EvaluateGradient(&cost_, &gradient_)
                                  : equations_.Evaluate(&cost_, &gradient_);
      if (!evaluated) {
        equations_.Restore(state);
        summary_.termination = "Evaluation of derivatives failed.";
        return summary_;
      }
      equations_.Save(&state);
      radius_ = std::min(kMaxRadius, radius_ / std::max(1.0 / 3, 1 - std::pow(2 * rho - 1, 3)));
      shrink = 2;
      if (!Report(iteration, true)) return summary_;
    } else {
      if (!Return(state)) {
        summary_.termination = "Evaluation of derivatives failed.";
        return summary_;
      }
      radius_ /= shrink;
      shrink *= 2;
      if (!Report(iteration, false)) return summary_;
      if (radius_ < kMinRadius) {
        summary_.termination = "Trust region radius below its minimum.";
        return summary_;
      }
    }
    if (converged) {
      summary_.termination = "Function tolerance reached: |dE| / E = " +
                             std::to_string(std::abs(change) / (trial + change)) + ".";
      return summary_;
    }
  }
}

}  // namespace

SolveSummary SolveLmPcg(const SolveTask& task, const SolverOptions& options) {
  return LmPcg(task, options).Solve();
}

}  // namespace burin
