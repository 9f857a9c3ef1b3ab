// burin's normal equations against those that follow from Ceres' own Jacobian.
#include "core/normal_equations.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <cmath>
#include <memory>

#include "core/motion.h"
#include "core/parallel.h"
#include "core/round.h"
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
    photometric.BeginLevel(views);
    photometric.BeginRound(context);
    smoothness.BeginRound(context);
    positions = mesh.vertices;
    ceres::Problem::Options options;
    options.evaluation_callback = &photometric;
    problem = std::make_unique<ceres::Problem>(options);
    photometric.AddResiduals(problem.get(), &positions);
    smoothness.AddResiduals(problem.get(), &positions);
    for (size_t v = 0; v < positions.size(); v += 5) {
      problem->AddResidualBlock(
          new ceres::AutoDiffCostFunction<ScaledDistance, 3, 3, 2>(new ScaledDistance), nullptr,
          positions[v].data(), extra);
    }
    for (size_t v = 0; v < positions.size(); ++v) {
      double* block = positions[v].data();
      if (!problem->HasParameterBlock(block)) continue;
      order.push_back(block);
      if (context.normals[v].isZero() || v % 7 == 3) {
        problem->SetParameterBlockConstant(block);
      } else if (motion == Motion::kNormal) {
        problem->SetManifold(block, new LineAlongNormal(context.normals[v]));
      }
    }
  }

  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  PhotometricEnergy photometric{PhotometricOptions()};
  SmoothnessEnergy smoothness{SmoothnessOptions()};
  std::vector<Eigen::Vector3d> positions;
  double extra[2] = {0.2, -0.4};
  std::vector<double*> order;
  std::unique_ptr<ceres::Problem> problem;
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
    NormalEquations equations(round.problem.get(), &round.photometric, round.order);
    ceres::Problem::EvaluateOptions evaluate;
    int constant = 0;
    for (double* block : round.order) {
      constant += round.problem->IsParameterBlockConstant(block) ? 1 : 0;
      if (!round.problem->IsParameterBlockConstant(block)) {
        evaluate.parameter_blocks.push_back(block);
      }
    }
    EXPECT_GT(constant, 10);
    evaluate.parameter_blocks.push_back(round.extra);
    // Twice, at different points: what is kept between evaluations must not leak.
    for (int repeat = 0; repeat < 2; ++repeat) {
      double reference_cost = 0;
      std::vector<double> reference_gradient;
      ceres::CRSMatrix crs;
      ASSERT_TRUE(
          round.problem->Evaluate(evaluate, &reference_cost, nullptr, &reference_gradient, &crs));
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

TEST(NormalEquations, ConstantBlocksStay) {
  Round round(Motion::kFree);
  NormalEquations equations(round.problem.get(), &round.photometric, round.order);
  const std::vector<Eigen::Vector3d> before = round.positions;
  NormalEquations::State state;
  equations.Save(&state);
  ASSERT_TRUE(equations.SetPlus(state, Eigen::VectorXd::Ones(equations.unknowns())));
  for (size_t v = 0; v < before.size(); ++v) {
    double* block = round.positions[v].data();
    const bool constant =
        !round.problem->HasParameterBlock(block) || round.problem->IsParameterBlockConstant(block);
    EXPECT_EQ(round.positions[v], before[v] + (constant ? 0.0 : 1.0) * Eigen::Vector3d::Ones());
  }
  equations.Restore(state);
  EXPECT_EQ(round.positions, before);
}

// Several batches of residual blocks, so that rows are added to in more than one.
TEST(NormalEquations, SameBytesForAnyNumberOfThreads) {
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    SetThreadCount(1);
    std::unique_ptr<Eigen::VectorXd> gradient_one;
    std::vector<double> values_one;
    double cost_one = 0;
    for (const int threads : {1, 2, 4}) {
      SetThreadCount(threads);
      Round round(motion);
      for (int repeat = 0; repeat < 40; ++repeat) {
        round.smoothness.AddResiduals(round.problem.get(), &round.positions);
      }
      ASSERT_GT(round.problem->NumResidualBlocks(), 5000);
      NormalEquations equations(round.problem.get(), &round.photometric, round.order);
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
  SetThreadCount(0);
}

}  // namespace
}  // namespace burin
