// burin's normal equations against those that follow from Ceres' own Jacobian.
#include "core/solve/normal_equations.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/refine/round.h"
#include "core/solve/ceres_problem.h"
#include "core/solve/motion.h"
#include "core/solve/sparse_cholesky.h"
#include "core/solve/strategies.h"
#include "core/support/parallel.h"
#include "costs/photometric_energy.h"
#include "costs/smoothness_energy.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// A user's residual: distances of a vertex, scaled by an unknown of its own, to the origin.
struct ScaledDistance {
  template <typename T>
  bool operator()(const T* vertex, const T* scale, T* residuals) const {
    for (int c = 0; c < 3; ++c) residuals[c] = 0.3 * exp(scale[0]) * vertex[c] + 0.1 * scale[1];
    return true;
  }
};

// Photometric and smoothness residuals and some of a user's, with constant blocks among them.
struct Round {
  explicit Round(Motion motion) {
    mesh = test::OccluderMesh();
    views = test::RandomViews(96, 80);
    context = FreezeRound(views, test::AllPairs(), mesh, motion, 2, &domains);
    photometric_term.BeginLevel(views);
    photometric = photometric_term.FreezeRound(context);
    smoothness = smoothness_term.Freeze(context);
    parameters.vertices = mesh.vertices;
    energy = std::make_unique<RoundEnergy>(&parameters);
    energy->BeginTerm("photometric");
    photometric->AddBlocks(energy.get());
    energy->BeginTerm("smoothness");
    smoothness->AddBlocks(energy.get());
    energy->BeginTerm("user");
    for (size_t v = 0; v < positions.size(); v += 5) {
      energy->Add(std::make_unique<ceres::AutoDiffCostFunction<ScaledDistance, 3, 3, 2>>(
                      new ScaledDistance),
                  nullptr, {positions[v].data(), extra});
    }
    lines.reserve(positions.size());
    for (const int v : energy->Used()) {
      if (v >= static_cast<int>(positions.size())) continue;
      if (context.normals[v].isZero() || v % 7 == 3) {
        energy->SetConstant(v);
        ++constant;
      } else if (motion == Motion::kNormal) {
        energy->SetManifold(v, &lines.emplace_back(context.normals[v]));
      }
    }
  }

  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  PhotometricEnergy photometric_term{PhotometricOptions()};
  SmoothnessEnergy smoothness_term{SmoothnessOptions()};
  std::unique_ptr<PhotometricRound> photometric;
  std::unique_ptr<TermRound> smoothness;
  RoundParameters parameters;
  std::vector<Eigen::Vector3d>& positions = parameters.vertices;
  double extra[2] = {0.2, -0.4};
  std::vector<LineAlongNormal> lines;
  int constant = 0;
  std::unique_ptr<RoundEnergy> energy;
};

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;

Sparse ToEigen(const SymmetricMatrix& matrix) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < matrix.size; ++row) {
    for (int64_t k = matrix.start[row]; k < matrix.start[row + 1]; ++k) {
      entries.emplace_back(row, matrix.column[k], matrix.value[k]);
    }
  }
  Sparse result(matrix.size, matrix.size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

TEST(NormalEquations, AgreeWithCeresJacobian) {
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    Round round(motion);
    NormalEquations equations(*round.energy, round.photometric.get());
    const CeresProblem problem(*round.energy, round.photometric.get());
    ceres::Problem::EvaluateOptions evaluate;
    for (const int p : round.energy->Moving()) {
      evaluate.parameter_blocks.push_back(round.energy->Values(p));
    }
    EXPECT_GT(round.constant, 10);
    EXPECT_EQ(evaluate.parameter_blocks.back(), round.extra);
    // Twice, at different points: what is kept between evaluations must not leak.
    for (int repeat = 0; repeat < 2; ++repeat) {
      double reference_cost = 0;
      std::vector<double> reference_gradient;
      ceres::CRSMatrix crs;
      ASSERT_TRUE(problem->Evaluate(evaluate, &reference_cost, nullptr, &reference_gradient, &crs));
      const Eigen::Map<const Sparse> jacobian(crs.num_rows, crs.num_cols,
                                              static_cast<long>(crs.values.size()), crs.rows.data(),
                                              crs.cols.data(), crs.values.data());
      const Sparse reference = Sparse(jacobian.transpose()) * jacobian;
      const Eigen::Map<const Eigen::VectorXd> expected(
          reference_gradient.data(), static_cast<long>(reference_gradient.size()));

      double cost = 0;
      Eigen::VectorXd gradient;
      ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
      ASSERT_EQ(equations.unknowns(), crs.num_cols);
      EXPECT_NEAR(cost, reference_cost, 1e-12 * reference_cost);
      EXPECT_LT((gradient - expected).norm(), 1e-12 * expected.norm());
      const Sparse matrix = ToEigen(equations.matrix());
      EXPECT_LT((matrix - reference).norm(), 1e-12 * reference.norm());
      EXPECT_EQ((matrix - Sparse(matrix.transpose())).norm(), 0);
      EXPECT_EQ(equations.matrix().Diagonal(), Eigen::VectorXd(matrix.diagonal()));

      double other = 0;
      Eigen::VectorXd first_order;
      ASSERT_TRUE(equations.EvaluateGradient(&other, &first_order));
      EXPECT_EQ(other, cost);
      EXPECT_EQ(first_order, gradient);
      ASSERT_TRUE(equations.EvaluateCost(&other));
      EXPECT_EQ(other, cost);

      test::Random random(11);
      Eigen::VectorXd x(equations.unknowns());
      for (double& entry : x) entry = random.Uniform();
      Eigen::VectorXd product;
      equations.matrix().Multiply(x, Eigen::VectorXd(), &product);
      EXPECT_LT((product - reference * x).norm(), 1e-12 * product.norm());
      NormalEquations::State state;
      equations.Save(&state);
      ASSERT_TRUE(equations.SetPlus(state, 0.01 * x));
      NormalEquations::State moved;
      equations.Save(&moved);
      EXPECT_NE(moved, state);
    }
  }
}

// The worked example of docs/extending.md: Gauss-Newton with Cholesky and step halving.
SolveSummary SolveGaussNewton(const SolveTask& task, const SolverOptions& options) {
  NormalEquations equations(*task.energy, task.evaluation_callback);
  SolveSummary summary;
  summary.unknowns = equations.unknowns();
  double cost = 0;
  Eigen::VectorXd gradient;
  if (!equations.Evaluate(&cost, &gradient)) return summary;  // usable stays false
  summary.usable = true;
  summary.initial_energy = cost;
  summary.termination = "Maximum number of iterations reached.";
  SparseCholesky factor;
  NormalEquations::State state;
  for (int i = 1; i <= options.max_iterations; ++i) {
    equations.Save(&state);
    if (!factor.Factor(equations.matrix(), 1e-3 * equations.matrix().Diagonal())) break;
    Eigen::VectorXd step;
    factor.ApplyInverseLower(-gradient, &step);
    factor.ApplyInverseUpper(Eigen::VectorXd(step), &step);
    double trial = cost;
    double share = 1;
    while (share > 1e-3 && !(equations.SetPlus(state, share * step) &&
                             equations.EvaluateCost(&trial) && trial < cost)) {
      share /= 2;
    }
    if (share <= 1e-3) {
      equations.Restore(state);
      summary.termination = "No step lowers the energy.";
      break;
    }
    const double before = cost;
    equations.Evaluate(&cost, &gradient);  // the callback has this point already
    summary.iterations = i;
    IterationRecord record;
    record.iteration = i;
    record.energy = cost;
    record.gradient_max = gradient.cwiseAbs().maxCoeff();
    record.step_norm = share * step.norm();
    if (task.on_iteration && !task.on_iteration(record)) break;
    if (before - cost <= options.function_tolerance * before) {
      summary.termination = "Function tolerance reached.";
      break;
    }
  }
  summary.final_energy = cost;
  return summary;
}

SolveTask TaskOf(Round* round) {
  SolveTask task;
  task.energy = round->energy.get();
  task.evaluation_callback = round->photometric.get();
  task.vertices = &round->positions;
  task.context = &round->context;
  return task;
}

// Every strategy on normal equations lowers the energy of the problem and keeps constant blocks, in
// both motions.
TEST(OwnStrategies, LowerTheEnergyAndKeepConstantBlocks) {
  using Solver = SolveSummary (*)(const SolveTask&, const SolverOptions&);
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    for (const Solver solve :
         {Solver(SolveGaussNewton), SolveLmPcg, SolveLbfgsSobolev, SolveLbfgsH}) {
      Round round(motion);
      const std::vector<Eigen::Vector3d> before = round.positions;
      SolveTask task = TaskOf(&round);
      std::vector<IterationRecord> records;
      task.on_iteration = [&](const IterationRecord& record) {
        records.push_back(record);
        return true;
      };
      const SolveSummary summary = solve(task, SolverOptions());
      EXPECT_TRUE(summary.usable);
      EXPECT_LT(summary.final_energy, 0.95 * summary.initial_energy);
      double energy = 0;
      const CeresProblem problem(*round.energy, round.photometric.get());
      ASSERT_TRUE(
          problem->Evaluate(ceres::Problem::EvaluateOptions(), &energy, nullptr, nullptr, nullptr));
      EXPECT_NEAR(energy, summary.final_energy, 1e-12 * energy);
      ASSERT_FALSE(records.empty());
      // Ceres does not report the step that ends a line search by tolerance.
      EXPECT_GE(records.back().energy, summary.final_energy);
      EXPECT_GT(records.back().step_norm, 0);
      const std::vector<int> moving = round.energy->Moving();
      for (size_t v = 0; v < before.size(); ++v) {
        if (!std::binary_search(moving.begin(), moving.end(), static_cast<int>(v))) {
          EXPECT_EQ(round.positions[v], before[v]);
        }
      }
    }
  }
}

TEST(OwnStrategies, LmPcgLeavesWhenTheNextStepIsShort) {
  Round round(Motion::kNormal);
  SolveTask task = TaskOf(&round);
  SolverOptions options;
  options.function_tolerance = 0;
  options.max_iterations = 40;
  std::vector<double> steps;
  task.on_iteration = [&](const IterationRecord& record) {
    if (record.iteration > 0) steps.push_back(record.step_norm);
    return true;
  };
  SolveLmPcg(task, options);
  ASSERT_GT(steps.size(), 5);
  // A limit between the fourth and the shortest earlier step: three steps are taken.
  const double earlier = std::min({steps[0], steps[1], steps[2]});
  ASSERT_LT(steps[3], earlier);
  NormalEquations equations(*round.energy, round.photometric.get());
  const double moving = static_cast<double>(equations.moving_blocks().size());
  Round again(Motion::kNormal);
  task = TaskOf(&again);
  task.pixel = 4;
  options.min_step_px = 0.5 * (steps[3] + earlier) / std::sqrt(moving) / task.pixel;
  EXPECT_EQ(SolveLmPcg(task, options).iterations, 3);
}

TEST(NormalEquations, ConstantBlocksStay) {
  Round round(Motion::kFree);
  NormalEquations equations(*round.energy, round.photometric.get());
  const std::vector<Eigen::Vector3d> before = round.positions;
  NormalEquations::State state;
  equations.Save(&state);
  ASSERT_TRUE(equations.SetPlus(state, Eigen::VectorXd::Ones(equations.unknowns())));
  const std::vector<int> moving = round.energy->Moving();
  for (size_t v = 0; v < before.size(); ++v) {
    const bool constant = !std::binary_search(moving.begin(), moving.end(), static_cast<int>(v));
    EXPECT_EQ(round.positions[v], before[v] + (constant ? 0.0 : 1.0) * Eigen::Vector3d::Ones());
  }
  equations.Restore(state);
  EXPECT_EQ(round.positions, before);
}

// Energy and gradient of a robust block are those that Ceres makes of it; its curvature is J^T J by the weight.
TEST(NormalEquations, LossesAreTakenAsCeresTakesThem) {
  Round round(Motion::kNormal);
  round.energy->BeginTerm("robust");
  for (size_t v = 0; v < round.positions.size(); v += 3) {
    round.energy->Add(
        std::make_unique<ceres::AutoDiffCostFunction<ScaledDistance, 3, 3, 2>>(new ScaledDistance),
        std::make_unique<ceres::HuberLoss>(0.05), {round.positions[v].data(), round.extra});
  }
  const CeresProblem problem(*round.energy, round.photometric.get());
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.residual_blocks =
      problem.ResidualBlocks([](const std::string& term) { return term == "robust"; });
  double of_term = 0;
  ASSERT_TRUE(problem->Evaluate(evaluate, &of_term, nullptr, nullptr, nullptr));
  EXPECT_GT(of_term, 0);
  EXPECT_NEAR(round.energy->EnergyOf("robust"), of_term, 1e-12 * of_term);

  evaluate.residual_blocks.clear();
  for (const int p : round.energy->Moving()) {
    evaluate.parameter_blocks.push_back(round.energy->Values(p));
  }
  double expected_cost = 0;
  std::vector<double> expected;
  ASSERT_TRUE(problem->Evaluate(evaluate, &expected_cost, nullptr, &expected, nullptr));
  NormalEquations equations(*round.energy, round.photometric.get());
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  EXPECT_NEAR(cost, expected_cost, 1e-12 * cost);
  const Eigen::Map<const Eigen::VectorXd> map(expected.data(), static_cast<long>(expected.size()));
  EXPECT_LT((gradient - map).norm(), 1e-12 * gradient.norm());
}

// Several batches of blocks, so that rows are added to in more than one.
TEST(NormalEquations, SameBytesForAnyNumberOfThreads) {
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    std::unique_ptr<Eigen::VectorXd> gradient_one;
    std::vector<double> values_one;
    double cost_one = 0;
    for (const int threads : {1, 2, 4}) {
      const ThreadScope scope(threads);
      Round round(motion);
      for (int repeat = 0; repeat < 40; ++repeat) {
        round.smoothness->AddBlocks(round.energy.get());
      }
      int blocks = 0;
      for (const RoundEnergy::Part& part : round.energy->parts()) blocks += part.blocks->size();
      ASSERT_GT(blocks, 5000);
      NormalEquations equations(*round.energy, round.photometric.get());
      double cost = 0;
      Eigen::VectorXd gradient;
      ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
      if (threads == 1) {
        cost_one = cost;
        gradient_one = std::make_unique<Eigen::VectorXd>(gradient);
        values_one = equations.matrix().value;
      } else {
        EXPECT_EQ(cost, cost_one);
        EXPECT_EQ(gradient, *gradient_one);
        EXPECT_EQ(equations.matrix().value, values_one);
      }
    }
  }
}

}  // namespace
}  // namespace burin
