// Steps in surface and cameras together: the linear systems, and a rendered scene whose cameras are wrong.
#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "core/refine/frozen_round.h"
#include "core/refine/normalized_world.h"
#include "core/refine/round.h"
#include "core/solve/ceres_problem.h"
#include "core/solve/normal_equations.h"
#include "core/support/parallel.h"
#include "costs/photometric_energy.h"
#include "costs/smoothness_energy.h"
#include "tests/dense_matrix.h"
#include "tests/small_relief.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

using test::Random;

// A round of photometric and smoothness energy with moving cameras.
struct Round {
  Round(const std::vector<LevelView>& level_views, const std::vector<CameraPair>& pairs,
        TriangleMesh start, Motion motion, bool double_precision = false)
      : mesh(std::move(start)), views(level_views) {
    context = FreezeRound(views, pairs, mesh, motion, 2, &domains);
    PhotometricOptions options;
    options.double_precision = double_precision;
    photometric = std::make_unique<PhotometricEnergy>(options);
    smoothness = std::make_unique<SmoothnessEnergy>(SmoothnessOptions());
    photometric->BeginLevel(views);
    const std::vector<EnergyTerm*> both = {photometric.get(), smoothness.get()};
    terms = std::make_unique<TermRounds>(both, context);
    parameters.vertices = mesh.vertices;
    for (const LevelView& view : views) parameters.cameras.push_back(PoseOf(view.camera));
  }
  RoundProblem& Problem() {
    problem = std::make_unique<RoundProblem>(*terms, context, &parameters);
    problem->SupportIsKnown();
    return *problem;
  }
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> photometric;
  std::unique_ptr<SmoothnessEnergy> smoothness;
  std::unique_ptr<TermRounds> terms;
  RoundParameters parameters;
  std::unique_ptr<RoundProblem> problem;
};

class MovingBorder : public testing::TestWithParam<Motion> {};
INSTANTIATE_TEST_SUITE_P(Motions, MovingBorder, testing::Values(Motion::kNormal, Motion::kFree),
                         [](const auto& test) { return NameOf(test.param); });

TEST_P(MovingBorder, GradientIsThatOfTheEnergy) {
  Round round(test::RandomViews(96, 80), test::AllPairs(), test::OccluderMesh(), GetParam(), true);
  const SolveTask& task = round.Problem().task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  EXPECT_EQ(equations.unknowns(), round.problem->Unknowns());
  EXPECT_EQ(equations.border().unknowns(), 18);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  NormalEquations::State state;
  equations.Save(&state);
  Random random(5);
  for (int trial = 0; trial < 6; ++trial) {
    Eigen::VectorXd direction(equations.unknowns());
    for (double& entry : direction) entry = 1e-7 * random.Uniform();
    if (trial % 2 == 1) direction.head(equations.matrix().size).setZero();
    double values[2];
    for (int side = 0; side < 2; ++side) {
      ASSERT_TRUE(equations.SetPlus(state, side == 0 ? direction : -direction));
      ASSERT_TRUE(equations.EvaluateCost(&values[side]));
    }
    const double numeric = (values[0] - values[1]) / 2;
    EXPECT_NEAR(gradient.dot(direction), numeric, 1e-4 * std::abs(numeric));
  }
}

TEST_P(MovingBorder, MatrixIsSymmetricAndPositive) {
  Round round(test::RandomViews(96, 80), test::AllPairs(), test::OccluderMesh(), GetParam(), true);
  const SolveTask& task = round.Problem().task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  const Eigen::MatrixXd dense = test::Dense(equations);
  EXPECT_LT((dense - dense.transpose()).norm(), 1e-13 * dense.norm());
  EXPECT_EQ(Eigen::VectorXd(dense.diagonal()), equations.Diagonal());
  const Eigen::VectorXd scale = dense.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * dense * scale.asDiagonal();
  scaled.diagonal().array() += 1e-9;
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(scaled).info(), Eigen::Success);

  // The preconditioner is a matrix that is larger, and its inverse is one.
  const int rows = equations.matrix().size;
  std::vector<int> first;
  for (const NormalEquations::MovingBlock& block : equations.moving_blocks()) {
    if (block.first_unknown < rows) first.push_back(block.first_unknown);
  }
  first.push_back(rows);
  const Eigen::VectorXd damping = 1e-6 * equations.Diagonal();
  BlockJacobi surface;
  surface.FactorMajorant(equations.matrix(), damping.head(rows), first);
  CameraBorder* border = equations.mutable_border();
  ASSERT_TRUE(border->Factor(surface, damping.tail(border->unknowns())));
  const int size = equations.unknowns();
  Eigen::MatrixXd inverse(size, size);
  Eigen::VectorXd column;
  for (int u = 0; u < size; ++u) {
    border->ApplyInverse(surface, Eigen::VectorXd::Unit(size, u), &column);
    inverse.col(u) = column;
  }
  const Eigen::MatrixXd preconditioner = inverse.inverse();
  const Eigen::MatrixXd difference =
      scale.asDiagonal() * (preconditioner - dense) * scale.asDiagonal();
  const Eigen::MatrixXd corner = difference.bottomRightCorner(18, 18);
  EXPECT_LT(corner.norm(), 1e-4);
  EXPECT_LT(difference.topRightCorner(rows, 18).norm(), 1e-4);
  Eigen::MatrixXd more = (difference + difference.transpose()) / 2;
  more.diagonal().array() += 1e-4;
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(more).info(), Eigen::Success);
}

// What a user's term may have of cameras alone: where one is, and how far two are apart.
struct Place {
  template <typename T>
  bool operator()(const T* pose, T* residuals) const {
    for (int c = 0; c < CameraPose::kSize; ++c) residuals[c] = (1.0 + c) * (pose[c] - 0.1 * c);
    return true;
  }
};
struct Baseline {
  template <typename T>
  bool operator()(const T* a, const T* b, T* residuals) const {
    for (int c = 0; c < 3; ++c) residuals[c] = a[4 + c] * a[4 + c] - 2.0 * b[4 + c] + a[0] * b[1];
    return true;
  }
};

TEST(Border, CostFunctionsOfCamerasAreAddedAsCeresAddsThem) {
  RoundParameters parameters;
  for (const LevelView& view : test::RandomViews(96, 80)) {
    parameters.cameras.push_back(PoseOf(view.camera));
  }
  std::vector<CameraPose>& cameras = parameters.cameras;
  RoundEnergy energy(&parameters);
  energy.BeginTerm("places");
  constexpr int kSize = CameraPose::kSize;
  energy.Add(std::make_unique<ceres::AutoDiffCostFunction<Place, kSize, kSize>>(new Place), nullptr,
             {cameras[1].data()});
  energy.Add(std::make_unique<ceres::AutoDiffCostFunction<Baseline, 3, kSize, kSize>>(new Baseline),
             nullptr, {cameras[2].data(), cameras[0].data()});
  energy.Add(std::make_unique<ceres::AutoDiffCostFunction<Baseline, 3, kSize, kSize>>(new Baseline),
             nullptr, {cameras[0].data(), cameras[1].data()});
  PoseManifold motion;
  for (int i = 0; i < 2; ++i) energy.SetManifold(energy.FirstCamera() + i, &motion);
  energy.SetConstant(energy.FirstCamera() + 2);
  NormalEquations equations(energy, nullptr);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  ASSERT_EQ(equations.unknowns(), 12);

  const CeresProblem problem(energy, nullptr);
  ceres::Problem::EvaluateOptions evaluate;
  for (int i = 0; i < 2; ++i) evaluate.parameter_blocks.push_back(cameras[i].data());
  double expected = 0;
  std::vector<double> slope;
  ceres::CRSMatrix crs;
  ASSERT_TRUE(problem->Evaluate(evaluate, &expected, nullptr, &slope, &crs));
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(crs.num_rows, crs.num_cols);
  for (int row = 0; row < crs.num_rows; ++row) {
    for (int k = crs.rows[row]; k < crs.rows[row + 1]; ++k) {
      jacobian(row, crs.cols[k]) += crs.values[k];
    }
  }
  EXPECT_NEAR(cost, expected, 1e-12 * expected);
  EXPECT_LT((gradient - Eigen::Map<Eigen::VectorXd>(slope.data(), 12)).norm(),
            1e-12 * gradient.norm());
  const Eigen::MatrixXd matrix = jacobian.transpose() * jacobian;
  EXPECT_LT((test::Dense(equations) - matrix).norm(), 1e-12 * matrix.norm());
}

// The relief at 240x180 and its cameras with noise: 1 px of rotation and half a pixel of place.
struct WrongCameras {
  WrongCameras() {
    synthetic = MakeSyntheticScene(test::SmallReliefOptions(5));
    world = NormalizedWorld::Of(synthetic.scene, synthetic.init);
    mesh = world.FromWorld(synthetic.init);
    views = MakeLevelViews(synthetic.scene, 0, world.origin, 1 / world.footprint);
    Random random(11);
    for (LevelView& view : views) {
      truth.push_back(view.camera);
      CameraPose pose = PoseOf(view.camera);
      const double px = std::sqrt(3.0) / view.camera.fx;  // a uniform number's of RMS 1
      const double distance = view.camera.Center().norm();
      const Eigen::Vector3d turn = px * random.Vector().cwiseProduct(Eigen::Vector3d(1, 1, 2));
      Eigen::Map<Eigen::Vector3d>(pose.center) += 0.5 * px * distance * random.Vector();
      SetPose(pose, &view.camera);
      view.camera.translation =
          Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() *
          view.camera.translation;
      view.camera.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() *
                             view.camera.rotation;
    }
    for (size_t i = 0; i < views.size(); ++i) {
      for (size_t j = 0; j < views.size(); ++j) {
        if (i != j && std::abs(static_cast<int>(i) - static_cast<int>(j)) < 3) {
          pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
        }
      }
    }
    points = world.FromWorld({synthetic.truth_points, {}}).vertices;
  }
  // RMS over all views of what points move in pixels, after the similarity that makes it least.
  double Error() const;
  // Two rounds; what does not move is `still`.
  enum class Still { kNothing, kCameras, kSurface };
  void Refine(Still still, int threads = 2, const std::string& strategy = "lm_pcg") {
    const ThreadScope scope(threads);
    for (int k = 0; k < 2; ++k) {
      Round round(views, pairs, mesh, Motion::kNormal);
      if (still == Still::kCameras) round.parameters.cameras.clear();
      if (still == Still::kSurface) {
        std::fill(round.context.moves.begin(), round.context.moves.end(), static_cast<char>(0));
      }
      SolverOptions options;
      options.max_iterations = 8;
      options.function_tolerance = 1e-5;
      const SolveTask& task = round.Problem().task;
      const SolveSummary summary = StrategyFor(strategy, 0, options).solve(task, options);
      EXPECT_TRUE(summary.usable);
      EXPECT_LT(summary.final_energy, summary.initial_energy);
      mesh.vertices = round.parameters.vertices;
      for (size_t i = 0; i < round.parameters.cameras.size(); ++i) {
        SetPose(round.parameters.cameras[i], &views[i].camera);
      }
    }
  }
  SyntheticScene synthetic;
  NormalizedWorld world;
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<Camera> truth;
  std::vector<CameraPair> pairs;
  std::vector<Eigen::Vector3d> points;
};

double WrongCameras::Error() const {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // scaled
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  double mean = 0;
  for (int iteration = 0; iteration < 6; ++iteration) {
    Eigen::Matrix<double, 7, 7> a = Eigen::Matrix<double, 7, 7>::Zero();
    Eigen::Matrix<double, 7, 1> b = Eigen::Matrix<double, 7, 1>::Zero();
    double square = 0;
    for (size_t i = 0; i < views.size(); ++i) {
      const Camera& camera = views[i].camera;
      for (const Eigen::Vector3d& point : points) {
        const Eigen::Vector3d turned = turn * point;
        const Eigen::Vector3d local = camera.rotation * (turned + shift) + camera.translation;
        const Eigen::Vector2d error = camera.Project(turned + shift) - truth[i].Project(point);
        Eigen::Matrix<double, 2, 3> projection;
        projection << camera.fx, 0, -camera.fx * local.x() / local.z(),  //
            0, camera.fy, -camera.fy * local.y() / local.z();
        projection = projection * camera.rotation / local.z();
        Eigen::Matrix<double, 3, 7> motion;
        for (int c = 0; c < 3; ++c) motion.col(c) = Eigen::Vector3d::Unit(c).cross(turned);
        motion.block<3, 3>(0, 3).setIdentity();
        motion.col(6) = turned;
        const Eigen::Matrix<double, 2, 7> jacobian = projection * motion;
        a += jacobian.transpose() * jacobian;
        b += jacobian.transpose() * error;
        square += error.squaredNorm();
      }
    }
    mean = std::sqrt(square / static_cast<double>(views.size() * points.size()));
    const Eigen::Matrix<double, 7, 1> step = -a.ldlt().solve(b);
    const Eigen::Vector3d axis = step.head<3>();
    turn = std::exp(step[6]) *
           Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix() * turn;
    shift += step.segment<3>(3);
  }
  return mean;
}

TEST(JointSteps, FindCamerasAndSurfaceTogether) {
  WrongCameras both;
  const double start = both.Error();
  EXPECT_GT(start, 0.7);
  both.Refine(WrongCameras::Still::kNothing);
  const double joint = both.Error();
  EXPECT_LT(joint, 0.1 * start);
  WrongCameras surface;
  surface.Refine(WrongCameras::Still::kCameras);
  EXPECT_EQ(surface.Error(), start);
  WrongCameras cameras;
  cameras.Refine(WrongCameras::Still::kSurface);
  EXPECT_GT(cameras.Error(), 2.5 * joint);
}

TEST(JointSteps, SameBytesForAnyNumberOfThreads) {
  for (const char* strategy : {"lm_pcg", "lm_cgnr", "gradient_descent"}) {
    WrongCameras one;
    one.Refine(WrongCameras::Still::kNothing, 1, strategy);
    WrongCameras two;
    two.Refine(WrongCameras::Still::kNothing, 2, strategy);
    EXPECT_EQ(one.mesh.vertices, two.mesh.vertices) << strategy;
    for (size_t i = 0; i < one.views.size(); ++i) {
      EXPECT_EQ(one.views[i].camera.rotation, two.views[i].camera.rotation) << strategy;
      EXPECT_EQ(one.views[i].camera.translation, two.views[i].camera.translation) << strategy;
    }
  }
}

// The share of the cameras' error that twelve iterations leave at most. Steps by a fixed length or the first H's go far less.
double ErrorLeft(const std::string& strategy) {
  return strategy == "gradient_descent" || strategy == "lbfgs_h" ? 0.95 : 0.6;
}

TEST(JointSteps, EveryStrategyMovesCamerasAndSurface) {
  WrongCameras scene;
  const double start_error = scene.Error();
  Round round(scene.views, scene.pairs, scene.mesh, Motion::kNormal);
  RoundProblem& problem = round.Problem();
  const std::vector<CameraPose> start = round.parameters.cameras;
  SolverOptions options;
  options.max_iterations = 12;
  options.function_tolerance = 1e-5;
  for (const Strategy& strategy : Strategies()) {
    const RoundTrial trial = problem.Try(strategy, options, scene.mesh.vertices, {});
    ASSERT_TRUE(trial.solve.usable) << strategy.name;
    EXPECT_EQ(trial.solve.unknowns, problem.Unknowns()) << strategy.name;
    EXPECT_LT(trial.solve.final_energy, 0.9 * trial.solve.initial_energy) << strategy.name;
    EXPECT_TRUE(round.parameters.cameras == start) << strategy.name;
    WrongCameras moved = scene;
    for (size_t i = 0; i < trial.cameras.size(); ++i) {
      SetPose(trial.cameras[i], &moved.views[i].camera);
    }
    const double share = moved.Error() / start_error;
    RecordProperty(strategy.name, std::to_string(share));
    EXPECT_LT(share, ErrorLeft(strategy.name)) << strategy.name;
  }
}

}  // namespace
}  // namespace burin
