// The silhouette term on spheres with the masks of a sphere.
#include "costs/silhouette_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/refine/frozen_round.h"
#include "core/refine/round.h"
#include "core/solve/ceres_problem.h"
#include "core/solve/normal_equations.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

constexpr int kSide = 96;

// The share of each pixel that a sphere around the origin covers.
cv::Mat1f SphereMask(const Camera& camera, double radius) {
  constexpr int kSub = 16;
  cv::Mat1f mask(camera.height, camera.width, 0.0F);
  for (int y = 0; y < camera.height * kSub; ++y) {
    for (int x = 0; x < camera.width * kSub; ++x) {
      const Eigen::Vector3d ray = camera.Ray((x + 0.5) / kSub, (y + 0.5) / kSub).normalized();
      if (ray.cross(camera.Center()).norm() < radius) {
        mask(y / kSub, x / kSub) += 1.0F / (kSub * kSub);
      }
    }
  }
  return mask;
}

// Views of a sphere around the origin from 10 radii away, in units of the world that are `unit`. One pixel is about a 20th
// of the radius, which is 20 units.
std::vector<LevelView> Views(double radius, double unit) {
  std::vector<LevelView> views;
  for (int i = 0; i < 6; ++i) {
    const double turn = i * 1.05;
    const Eigen::Vector3d centre(std::cos(turn), 0.3 * i - 0.7, std::sin(turn));
    LevelView& view = views.emplace_back();
    view.camera =
        test::LookAt(unit * 200 * centre.normalized(), Eigen::Vector3d::Zero(), kSide, kSide, 200);
    view.image = cv::Mat1f(kSide, kSide, 100.0F);
    view.object = SphereMask(view.camera, unit * radius);
  }
  return views;
}

struct Spheres {
  Spheres(double mesh_radius, double mask_radius, Motion motion, double unit = 1) {
    views = Views(mask_radius, unit);
    mesh = Sphere(unit * mesh_radius, 4);
    options.weight = 2;
    motion_ = motion;
  }
  // Frozen where the mesh is; every vertex may move.
  void Freeze() {
    context = FreezeRound(views, {{0, 1}}, mesh, motion_, 0, &domains);
    context.moves.assign(mesh.vertices.size(), 1);
    context.free.assign(mesh.vertices.size(), motion_ == Motion::kFree ? 1 : 0);
    term = std::make_unique<SilhouetteEnergy>(options);
    terms.emplace(std::vector<EnergyTerm*>{term.get()}, context);
    parameters.vertices = mesh.vertices;
    problem = std::make_unique<RoundProblem>(*terms, context, &parameters);
    problem->SupportIsKnown();
  }
  double Energy() const { return problem->EnergyByTerm()["silhouette"]; }
  std::vector<char> Outlined() const {
    std::vector<char> outlined(mesh.vertices.size(), 0);
    std::vector<char> thin = outlined;
    terms->Of(term.get()).MarkOutlined(&outlined, &thin);
    return outlined;
  }

  SilhouetteTermOptions options;
  std::vector<LevelView> views;
  TriangleMesh mesh;
  Motion motion_ = Motion::kNormal;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<SilhouetteEnergy> term;
  std::optional<TermRounds> terms;
  RoundParameters parameters;
  std::unique_ptr<RoundProblem> problem;
};

// At the frozen contours and away from where they were frozen.
TEST(SilhouetteEnergy, GradientIsThatOfTheEnergy) {
  Spheres spheres(20, 19.2, Motion::kFree);
  spheres.Freeze();
  const SolveTask& task = spheres.problem->task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  test::Random random(11);
  Eigen::VectorXd direction(equations.unknowns());
  NormalEquations::State start;
  equations.Save(&start);
  for (const double away : {0.0, 0.4}) {
    for (double& d : direction) d = random.Uniform();
    ASSERT_TRUE(equations.SetPlus(start, away * direction));
    NormalEquations::State here;
    equations.Save(&here);
    double cost = 0;
    Eigen::VectorXd gradient;
    ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
    EXPECT_GT(cost, 1);
    for (double& d : direction) d = random.Uniform();
    constexpr double kStep = 1e-4;
    double plus = 0;
    double minus = 0;
    ASSERT_TRUE(equations.SetPlus(here, kStep * direction) && equations.EvaluateCost(&plus));
    ASSERT_TRUE(equations.SetPlus(here, -kStep * direction) && equations.EvaluateCost(&minus));
    const double expected = (plus - minus) / (2 * kStep);
    EXPECT_NEAR(gradient.dot(direction), expected, 1e-4 * std::abs(expected));
  }
}

// Residuals and Jacobian for Ceres have the same energy and gradient.
TEST(SilhouetteEnergy, IsTheSameToCeres) {
  Spheres spheres(20, 19.2, Motion::kFree);
  spheres.Freeze();
  const SolveTask& task = spheres.problem->task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
  const CeresProblem problem(*task.energy, task.evaluation_callback);
  ceres::Problem::EvaluateOptions evaluate;
  for (const NormalEquations::MovingBlock& block : equations.moving_blocks()) {
    evaluate.parameter_blocks.push_back(block.values);
  }
  double ceres_cost = 0;
  std::vector<double> ceres_gradient;
  ASSERT_TRUE(problem->Evaluate(evaluate, &ceres_cost, nullptr, &ceres_gradient, nullptr));
  EXPECT_NEAR(ceres_cost, cost, 1e-9 * cost);
  const Eigen::Map<const Eigen::VectorXd> other(ceres_gradient.data(), gradient.size());
  EXPECT_LT((other - gradient).norm(), 1e-8 * gradient.norm());
}

TEST(SilhouetteEnergy, DoesNotDependOnTheUnitOfTheWorld) {
  Spheres spheres(20, 19.2, Motion::kNormal);
  Spheres others(20, 19.2, Motion::kNormal, 8);
  spheres.options.membrane = others.options.membrane = 0;
  spheres.Freeze();
  others.Freeze();
  EXPECT_GT(spheres.Energy(), 1);
  EXPECT_NEAR(others.Energy(), spheres.Energy(), 1e-6 * spheres.Energy());
}

// A mesh 1.5 pixels too large, or too small, ends on the sphere of the masks: the membrane takes along what lies between
// contours. Facets' chords lie up to .1 within the sphere of their vertices.
TEST(SilhouetteEnergy, FindsTheRadiusOfASphere) {
  for (const double start : {21.5, 18.5}) {
    Spheres spheres(start, 20, Motion::kFree);
    for (int round = 0; round < 15; ++round) {
      spheres.Freeze();
      const RoundTrial trial = spheres.problem->Try(*FindStrategy("lm_pcg", 1000, SolverOptions()),
                                                    SolverOptions(), spheres.mesh.vertices, {});
      ASSERT_TRUE(trial.solve.usable);
      spheres.mesh.vertices = trial.vertices;
    }
    spheres.Freeze();
    const std::vector<char> outlined = spheres.Outlined();
    double sum = 0;
    int count = 0;
    for (size_t v = 0; v < outlined.size(); ++v) {
      if (outlined[v] == 0) continue;
      sum += spheres.mesh.vertices[v].norm();
      ++count;
    }
    ASSERT_GT(count, 100);
    EXPECT_NEAR(sum / count, 20, 0.15) << start;
  }
}

TEST(SilhouetteEnergy, EveryStrategyLowersIt) {
  for (const Strategy& strategy : Strategies()) {
    Spheres spheres(21, 20, Motion::kNormal);
    spheres.Freeze();
    if (strategy.max_unknowns > 0 && spheres.problem->Unknowns() > strategy.max_unknowns) continue;
    const RoundTrial trial =
        spheres.problem->Try(strategy, SolverOptions(), spheres.mesh.vertices, {});
    ASSERT_TRUE(trial.solve.usable) << strategy.name;
    EXPECT_LT(trial.energy_final["silhouette"].get<double>(),
              0.5 * trial.energy_initial["silhouette"].get<double>())
        << strategy.name;
  }
}

// An outline that is nowhere near has no say: here that of a sphere twice as large.
TEST(SilhouetteEnergy, ContoursFarFromOutlinesAreLeftOut) {
  Spheres spheres(16, 32, Motion::kNormal);
  spheres.Freeze();
  EXPECT_EQ(spheres.Energy(), 0);
  const nlohmann::json report = spheres.terms->Of(spheres.term.get()).Report();
  EXPECT_EQ(report["views"][0]["unmatched"], 1);
}

// What lies behind the border of an undistorted picture is not known to be empty.
TEST(SilhouetteEnergy, NothingIsSaidOutsideThePhotograph) {
  Spheres spheres(20, 19, Motion::kNormal);
  spheres.Freeze();
  EXPECT_GT(spheres.Energy(), 1);
  for (LevelView& view : spheres.views) view.photographed = cv::Mat1b(kSide, kSide, uchar{0});
  spheres.Freeze();
  EXPECT_EQ(spheres.Energy(), 0);
}

}  // namespace
}  // namespace burin
