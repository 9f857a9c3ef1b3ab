// The silhouette term on spheres with the masks of a sphere.
#include "costs/silhouette_energy.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/refine/frozen_round.h"
#include "core/refine/round.h"
#include "core/solve/ceres_problem.h"
#include "core/solve/normal_equations.h"
#include "core/visibility/mesh_cover.h"
#include "costs/photometric_energy.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

constexpr int kSide = 96;
constexpr int kViews = 16;

// The share of each pixel that a sphere around the origin covers.
cv::Mat1f SphereMask(const Camera& camera, double radius) {
  constexpr int kSub = 8;
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

// Sphere() has the vertices of each split once for each facet.
TriangleMesh WeldedSphere(double radius) {
  const TriangleMesh apart = Sphere(radius, 4);
  TriangleMesh welded;
  std::map<std::array<double, 3>, int> index;
  std::vector<int> of_vertex;
  for (const Eigen::Vector3d& v : apart.vertices) {
    const auto [at, is_new] =
        index.emplace(std::array<double, 3>{v.x(), v.y(), v.z()}, welded.vertices.size());
    if (is_new) welded.vertices.push_back(v);
    of_vertex.push_back(at->second);
  }
  for (const Eigen::Vector3i& f : apart.faces) {
    welded.faces.emplace_back(of_vertex[f[0]], of_vertex[f[1]], of_vertex[f[2]]);
  }
  return welded;
}

// Views of a sphere around the origin from 10 radii away, in units of the world that are `unit`. One pixel is about a 20th
// of the radius, which is 20 units.
std::vector<LevelView> Views(double radius, double unit) {
  std::vector<LevelView> views;
  for (int i = 0; i < kViews; ++i) {
    const double turn = i * 2.4;  // the golden angle
    const Eigen::Vector3d centre(std::cos(turn), 2.0 * i / (kViews - 1) - 1, std::sin(turn));
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
    mesh = WeldedSphere(unit * mesh_radius);
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

// Residuals and Jacobian for Ceres have the same energy and gradient, within these shares of them.
void ExpectTheSameToCeres(NormalEquations* equations, const SolveTask& task, double of_cost,
                          double of_gradient) {
  double cost = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(equations->Evaluate(&cost, &gradient));
  const CeresProblem problem(*task.energy, task.evaluation_callback);
  ceres::Problem::EvaluateOptions evaluate;
  for (const NormalEquations::MovingBlock& block : equations->moving_blocks()) {
    evaluate.parameter_blocks.push_back(block.values);
  }
  double ceres_cost = 0;
  std::vector<double> values;
  ASSERT_TRUE(problem->Evaluate(evaluate, &ceres_cost, nullptr, &values, nullptr));
  ASSERT_EQ(static_cast<Eigen::Index>(values.size()), gradient.size());
  const Eigen::Map<const Eigen::VectorXd> other(values.data(), gradient.size());
  EXPECT_NEAR(ceres_cost, cost, of_cost * cost);
  EXPECT_LT((other - gradient).norm(), of_gradient * gradient.norm());
}

TEST(SilhouetteEnergy, IsTheSameToCeres) {
  Spheres spheres(20, 19.2, Motion::kFree);
  spheres.Freeze();
  const SolveTask& task = spheres.problem->task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  ExpectTheSameToCeres(&equations, task, 1e-9, 1e-8);
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
    spheres.options.membrane = 0.3;
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
    ASSERT_GT(count, 60);
    EXPECT_NEAR(sum / count, 20, 0.1)
        << start;  // from outside it is their visual hull, a little larger
    const nlohmann::json report = spheres.terms->Of(spheres.term.get()).Report();
    for (const nlohmann::json& view : report["views"]) {
      EXPECT_NEAR(view["signed_px"].get<double>(), 0, 0.05) << start;
    }
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

// The photometric term where some vertices move freely and others along their normal: Ceres sees the same gradient.
TEST(SilhouetteEnergy, PatchesOfFreeVerticesAreTheSameToCeres) {
  const TriangleMesh mesh = test::OccluderMesh();
  const std::vector<LevelView> views = test::RandomViews(80, 64);
  std::vector<ViewDomain> domains;
  RoundContext context = FreezeRound(views, test::AllPairs(), mesh, Motion::kNormal, 3, &domains);
  for (size_t v = 0; v < context.free.size(); v += 3) context.free[v] = 1;
  PhotometricEnergy photometric((PhotometricOptions()));
  photometric.BeginLevel(views);
  const TermRounds terms({&photometric}, context);
  RoundParameters parameters{mesh.vertices};
  RoundProblem problem(terms, context, &parameters);
  problem.SupportIsKnown();
  const SolveTask& task = problem.task;
  NormalEquations equations(*task.energy, task.evaluation_callback);
  EXPECT_EQ(equations.unknowns(), problem.Unknowns());
  ExpectTheSameToCeres(&equations, task, 1e-6, 1e-5);
}

// Of a mesh whose chords lie within the sphere.
TEST(MeshCover, IsTheAreaOfASphere) {
  const LevelView view = Views(20, 1)[0];
  const TriangleMesh mesh = WeldedSphere(20);
  const Adjacency faces = VertexFaces(mesh);
  const EdgeFacets edges(mesh, VertexNeighbors(mesh, faces), faces);
  const MeshCover cover(mesh, edges, view.camera, 16);
  const cv::Mat1f share = cover.Share(cv::Rect(0, 0, kSide, kSide));
  const double area = cv::sum(view.object)[0];
  EXPECT_NEAR(cv::sum(share)[0], area, 0.01 * area);
  EXPECT_LE(cv::norm(share, view.object, cv::NORM_INF), 0.2);
  EXPECT_TRUE(cover.Covers({kSide / 2.0, kSide / 2.0}));
  EXPECT_FALSE(cover.Covers({2, 2}));
  double length = 0;
  for (const MeshCover::Sample& sample : cover.Contour(0.5, 0.1)) length += sample.length;
  EXPECT_NEAR(length, 2 * std::sqrt(3.14159265 * area), 0.02 * length);
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
