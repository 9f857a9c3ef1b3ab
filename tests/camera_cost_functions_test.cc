// The energy of moving cameras as cost functions of Ceres: against burin's own normal equations.
#include <ceres/crs_matrix.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/refine/frozen_round.h"
#include "core/refine/round.h"
#include "core/solve/camera_units.h"
#include "core/solve/ceres_problem.h"
#include "core/solve/normal_equations.h"
#include "costs/photometric_energy.h"
#include "costs/smoothness_energy.h"
#include "tests/dense_matrix.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// A round of photometric and smoothness energy with moving cameras.
struct Round {
  explicit Round(Motion motion, bool double_precision = true)
      : mesh(test::OccluderMesh()), views(test::RandomViews(96, 80)) {
    context = FreezeRound(views, test::AllPairs(), mesh, motion, 2, &domains);
    PhotometricOptions options;
    options.double_precision = double_precision;
    photometric = std::make_unique<PhotometricEnergy>(options);
    smoothness = std::make_unique<SmoothnessEnergy>(SmoothnessOptions());
    photometric->BeginLevel(views);
    terms.emplace(std::vector<EnergyTerm*>{photometric.get(), smoothness.get()}, context);
    parameters.vertices = mesh.vertices;
    for (const LevelView& view : views) parameters.cameras.push_back(PoseOf(view.camera));
    problem = std::make_unique<RoundProblem>(*terms, context, &parameters);
    problem->SupportIsKnown();
  }
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> photometric;
  std::unique_ptr<SmoothnessEnergy> smoothness;
  std::optional<TermRounds> terms;
  RoundParameters parameters;
  std::unique_ptr<RoundProblem> problem;
};

// Of a ceres::Problem in the unknowns of the normal equations.
struct Evaluated {
  double energy = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd jacobian;
};
Evaluated Evaluate(const CeresProblem& problem, const NormalEquations& equations) {
  ceres::Problem::EvaluateOptions options;
  for (const NormalEquations::MovingBlock& block : equations.moving_blocks()) {
    options.parameter_blocks.push_back(block.values);
  }
  Evaluated result;
  std::vector<double> gradient;
  ceres::CRSMatrix crs;
  EXPECT_TRUE(problem->Evaluate(options, &result.energy, nullptr, &gradient, &crs));
  result.gradient = Eigen::Map<Eigen::VectorXd>(gradient.data(), gradient.size());
  result.jacobian.setZero(crs.num_rows, crs.num_cols);
  for (int row = 0; row < crs.num_rows; ++row) {
    for (int k = crs.rows[row]; k < crs.rows[row + 1]; ++k) {
      result.jacobian(row, crs.cols[k]) += crs.values[k];
    }
  }
  return result;
}

class CameraCostFunctions : public testing::TestWithParam<Motion> {};
INSTANTIATE_TEST_SUITE_P(Motions, CameraCostFunctions,
                         testing::Values(Motion::kNormal, Motion::kFree),
                         [](const auto& test) { return NameOf(test.param); });

TEST_P(CameraCostFunctions, HaveTheEnergyAndItsGradient) {
  Round round(GetParam());
  const SolveTask& task = round.problem->task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  const CeresProblem problem(*task.energy, task.evaluation_callback);
  const Evaluated evaluated = Evaluate(problem, equations);
  EXPECT_NEAR(evaluated.energy, cost, 1e-12 * cost);
  const int rows = equations.matrix().size;
  const int cameras = equations.border().unknowns();
  ASSERT_EQ(cameras, 18);
  EXPECT_LT((evaluated.gradient - gradient).head(rows).norm(), 1e-9 * gradient.head(rows).norm());
  EXPECT_LT((evaluated.gradient - gradient).tail(cameras).norm(),
            1e-7 * gradient.tail(cameras).norm());
  EXPECT_GT(gradient.tail(cameras).norm(), 1e-3);
}

// Cameras, and what couples them to vertices, as they are; vertices larger.
TEST_P(CameraCostFunctions, MajoriseTheCurvature) {
  Round round(GetParam());
  const SolveTask& task = round.problem->task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  const Eigen::MatrixXd own = test::Dense(equations);
  const CeresProblem problem(*task.energy, task.evaluation_callback);
  const Evaluated evaluated = Evaluate(problem, equations);
  const Eigen::MatrixXd more = evaluated.jacobian.transpose() * evaluated.jacobian - own;
  const Eigen::VectorXd root = own.diagonal().cwiseSqrt();
  const int rows = equations.matrix().size;
  for (int i = 0; i < more.rows(); ++i) {
    for (int j = std::max(i, rows); j < more.cols(); ++j) {
      EXPECT_NEAR(more(i, j), 0, 1e-6 * root[i] * root[j]) << i << ", " << j;
    }
  }
  const Eigen::MatrixXd surface = more.topLeftCorner(rows, rows) / own.diagonal().head(rows).mean();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(surface);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-3);  // damping of patches (costs/patch_system.h)
  EXPECT_GT(eigen.eigenvalues().maxCoeff(), 0.5);
  EXPECT_LT(surface.trace(), 3.0 * rows);
}

TEST(CameraUnits, GiveEveryCameraTheCurvatureOfVertices) {
  Round round(Motion::kNormal);
  const SolveTask& task = round.problem->task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  const CameraUnits units(*task.energy, task.evaluation_callback, /*damping=*/0);
  CeresProblem problem(*task.energy, task.evaluation_callback);
  problem.MoveCamerasIn(units);
  const Evaluated evaluated = Evaluate(problem, equations);
  EXPECT_NEAR(units.curvature(), equations.matrix().Diagonal().mean(), 1e-9 * units.curvature());
  const Eigen::MatrixXd cameras = evaluated.jacobian.rightCols(18);
  const Eigen::MatrixXd curvature = cameras.transpose() * cameras / units.curvature();
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT((curvature.block<6, 6>(6 * c, 6 * c) - Eigen::MatrixXd::Identity(6, 6)).norm(), 1e-4);
  }
}

}  // namespace
}  // namespace burin
