// The whole pipeline on scenes with known truth: energy and error fall, and what must not change the
// result does not change it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "apps/run/mesh_parts.h"
#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic.h"
#include "tests/small_relief.h"
#include "tests/split_facets.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

const SyntheticScene& Relief() {
  static const auto* scene = new SyntheticScene(MakeSyntheticScene(test::SmallReliefOptions(5)));
  return *scene;
}

double Rmse(const TriangleMesh& mesh) { return RmseToTruthMesh(mesh, Relief().truth, 20000); }

// RMSE to the truth that a strategy must reach on this scene, in pixels: a quarter more than it does. The
// initial mesh has 3.
double ReachedPx(const std::string& strategy) {
  const std::map<std::string, double> reached = {{"gradient_descent", 1.005},
                                                 {"steepest_descent", 0.289},
                                                 {"ncg", 0.30},
                                                 {"bfgs", 0.268},
                                                 {"lbfgs", 0.268},
                                                 {"lbfgs_sobolev", 0.159},
                                                 {"lbfgs_h", 0.201},
                                                 {"lm_cholesky", 0.161},
                                                 {"lm_cgnr", 0.161},
                                                 {"lm_pcg", 0.157},
                                                 {"dogleg", 0.161}};
  const auto found = reached.find(strategy);
  return found != reached.end() ? found->second : 0;  // a strategy without a row fails
}

TEST(Refinement, EveryStrategyLowersEnergyAndError) {
  for (const Strategy& strategy : Strategies()) {
    PipelineOptions options;
    options.refinement.solver.type = strategy.name;
    const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options);
    for (const LevelSummary& level : result.refinement.levels) {
      for (const RoundSummary& round : level.rounds) {
        EXPECT_LE(round.solve.final_energy, round.solve.initial_energy * (1 + 1e-12))
            << strategy.name;
        EXPECT_EQ(round.solve.strategy, strategy.name);
      }
    }
    const double reached_px = Rmse(result.mesh) / Relief().footprint;
    RecordProperty(strategy.name + "_rmse_px", std::to_string(reached_px));
    EXPECT_LT(reached_px, ReachedPx(strategy.name)) << strategy.name;
  }
}

// Trials on a frozen round start from the same point with nothing evaluated, whatever was tried
// before, and the refinement that goes on with one of them is the one that strategy makes alone.
TEST(Refinement, FrozenRoundsCanBeTriedAgain) {
  PipelineOptions options = test::SplitFacets();
  options.refinement.level.count = 2;
  options.refinement.level.rounds = 1;
  options.refinement.level.extra_rounds = 0;
  options.refinement.solver.max_iterations = 4;
  options.refinement.solver.type = "lm_cgnr";
  const TriangleMesh alone = RunPipeline(Relief().scene, Relief().init, options).mesh;
  int rounds = 0;
  PipelineParts parts;
  parts.solve_round = [&](const FrozenRound& frozen) {
    ++rounds;
    const RoundTrial first = frozen.solve("lm_cgnr", nullptr);
    for (const Strategy& strategy : Strategies()) {
      std::vector<Eigen::Vector3d> followed;
      double seconds = -1;
      const RoundTrial trial =
          frozen.solve(strategy.name, [&](const FrozenRound::Progress& progress) {
            if (followed.empty()) {
              EXPECT_EQ(*progress.vertices, frozen.context->mesh->vertices) << strategy.name;
              EXPECT_GE(progress.evaluations, 1)
                  << strategy.name << ": the start is not given away";
              EXPECT_NEAR(progress.record.energy, first.energy_initial["total"].get<double>(),
                          1e-9 * progress.record.energy)
                  << strategy.name << ": of all terms";
            }
            EXPECT_GE(progress.record.seconds, seconds) << strategy.name;
            seconds = progress.record.seconds;
            if (progress.record.accepted) followed = *progress.vertices;
            return true;
          });
      EXPECT_EQ(trial.energy_initial, first.energy_initial) << strategy.name;
      EXPECT_EQ(trial.solve.strategy, strategy.name);
      EXPECT_GE(trial.seconds, seconds) << strategy.name;
      EXPECT_NE(trial.vertices, frozen.context->mesh->vertices) << strategy.name;
      EXPECT_EQ(followed, trial.vertices) << strategy.name << ": the last call is for the result";
    }
    EXPECT_THROW(frozen.solve("newton", nullptr), InputError);
    const RoundTrial again = frozen.solve("lm_cgnr", nullptr);
    EXPECT_EQ(again.vertices, first.vertices);
    EXPECT_EQ(again.evaluations, first.evaluations);
    return again;
  };
  const TriangleMesh tried = RunPipeline(Relief().scene, Relief().init, options, parts).mesh;
  EXPECT_EQ(rounds, 2);
  EXPECT_EQ(tried.vertices, alone.vertices);
}

TEST(Refinement, FreeMotionWorksToo) {
  PipelineOptions options;
  options.refinement.motion = Motion::kFree;
  const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options);
  EXPECT_LT(Rmse(result.mesh), Rmse(Relief().init) / 4);
}

TEST(Refinement, CoarseLevelsHaveTheirOwnRoundsAndTolerance) {
  PipelineOptions options = test::SplitFacets();
  options.refinement.level.count = 2;
  options.refinement.level.extra_rounds = 2;
  options.refinement.level.rounds = 1;
  options.refinement.level.coarse_tolerance = 1;  // met by any step
  options.refinement.solver.function_tolerance = 1e-4;
  const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options);
  ASSERT_EQ(result.refinement.levels.size(), 2U);
  const LevelSummary& coarse = result.refinement.levels[0];
  const LevelSummary& finest = result.refinement.levels[1];
  ASSERT_EQ(coarse.rounds.size(), 3U);
  ASSERT_EQ(finest.rounds.size(), 1U);
  for (const RoundSummary& round : coarse.rounds) EXPECT_LE(round.solve.iterations, 2);
  EXPECT_GT(finest.rounds[0].solve.iterations, 2);
}

TEST(Refinement, ImagesBelowTheSmallestSideMakeNoLevel) {
  PipelineOptions options = test::SplitFacets();  // 240 x 180, 120 x 90, 60 x 45, 30 x 22.5
  options.refinement.level.count = 6;
  options.refinement.level.rounds = 1;
  options.refinement.level.extra_rounds = 0;
  options.refinement.solver.max_iterations = 1;
  for (const auto& [side, levels] : {std::pair{45, 3U}, {46, 2U}, {181, 1U}}) {
    options.refinement.level.min_side_px = side;
    const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options);
    EXPECT_EQ(result.refinement.levels.size(), levels) << side;
    EXPECT_EQ(result.refinement.levels.back().level, 0) << side;
  }
}

TEST(Refinement, ScaleOfTheWorldDoesNotMatter) {
  const PipelineOptions options;
  const TriangleMesh reference = RunPipeline(Relief().scene, Relief().init, options).mesh;
  const double diameter = BoundingDiagonal(reference);
  for (const double scale : {0.01, 100.0}) {
    Scene scene = Relief().scene;
    for (View& view : scene.views) {
      view.camera = view.camera.InScaledWorld(Eigen::Vector3d::Zero(), scale);
    }
    for (ScenePoint& point : scene.points) point.position *= scale;
    TriangleMesh init = Relief().init;
    for (Eigen::Vector3d& vertex : init.vertices) vertex *= scale;
    const TriangleMesh scaled = RunPipeline(scene, init, options).mesh;
    ASSERT_EQ(scaled.faces.size(), reference.faces.size());
    double largest = 0;
    for (size_t v = 0; v < reference.vertices.size(); ++v) {
      largest = std::max(largest, (scaled.vertices[v] / scale - reference.vertices[v]).norm());
    }
    EXPECT_LT(largest, 1e-4 * diameter) << "scale " << scale;
  }
}

TEST(Refinement, SameBytesForAnyNumberOfThreads) {
  PipelineOptions options;
  options.refinement.level.count = 2;
  options.threads = 1;
  const TriangleMesh one = RunPipeline(Relief().scene, Relief().init, options).mesh;
  for (const int threads : {2, 4}) {
    options.threads = threads;
    const TriangleMesh many = RunPipeline(Relief().scene, Relief().init, options).mesh;
    ASSERT_EQ(many.vertices.size(), one.vertices.size());
    for (size_t v = 0; v < one.vertices.size(); ++v) {
      ASSERT_EQ(many.vertices[v], one.vertices[v]) << threads << " threads, vertex " << v;
    }
  }
}

// Vertices that no pair sees are in the problem and do not move. Counted, they had `bfgs` refused early.
TEST(Refinement, UnknownsAreThoseOfTheVerticesThatMove) {
  TriangleMesh mesh = Relief().init;
  test::AppendGrid(&mesh, 90, 30, 0, 1, [](double, double) { return 0.0; });  // out of every view
  ASSERT_GT(mesh.vertices.size(), 8000U);
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    PipelineOptions options;
    options.refinement.motion = motion;
    options.refinement.level.count = 1;
    options.refinement.level.finest = 2;
    options.refinement.level.max_facet_px = 1e9;
    options.refinement.level.max_edge_px = 0;
    options.refinement.solver.type = "bfgs";
    options.refinement.solver.max_iterations = 1;
    int rounds = 0;
    PipelineParts parts;
    parts.solve_round = [&](const FrozenRound& round) {
      const RoundContext& context = *round.context;
      int moving = 0;
      for (size_t v = 0; v < context.normals.size(); ++v) {
        if (context.moves[v] != 0 && !context.normals[v].isZero()) ++moving;
      }
      EXPECT_EQ(round.unknowns, motion == Motion::kFree ? 3 * moving : moving);
      ++rounds;
      return round.solve("bfgs", {});
    };
    RunPipeline(Relief().scene, mesh, options, parts);
    EXPECT_GT(rounds, 0);
  }
}

TEST(Refinement, ACapOfFacesIsKeptAndTold) {
  PipelineOptions options;
  options.surface.trim = SurfaceTrim::kNone;
  options.refinement.level.count = 2;
  options.refinement.level.max_faces = 1000;
  const PipelineResult capped = RunPipeline(Relief().scene, Relief().init, options);
  EXPECT_LT(capped.mesh.faces.size(), 1010U);
  ASSERT_EQ(capped.refinement.levels.size(), 3U);  // the last on facets cut anew
  EXPECT_FALSE(capped.refinement.levels[1].reached_bound);
  EXPECT_FALSE(capped.refinement.levels[2].reached_bound);
  options.refinement.level.max_faces = PipelineOptions().refinement.level.max_faces;
  EXPECT_TRUE(
      RunPipeline(Relief().scene, Relief().init, options).refinement.levels.back().reached_bound);
}

TEST(Refinement, MeshOutsideEveryViewIsAnError) {
  TriangleMesh far = Relief().init;
  for (Eigen::Vector3d& vertex : far.vertices) vertex += Eigen::Vector3d(1000, 0, 0);
  EXPECT_THROW(RunPipeline(Relief().scene, far, PipelineOptions()), InputError);
}

TEST(Refinement, ClosedMeshesAreAcceptedAndInvertedOnesAreNot) {
  // An octahedron shows each camera less than half of its area, and none of its inside.
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  Scene scene;
  scene.views.resize(1);
  scene.views[0].camera = test::LookAt({0.5, 0.7, 6}, {0, 0, 0}, 320, 240, 300);
  CheckMeshIsSeen(scene, mesh, "mesh.ply");
  for (Eigen::Vector3i& face : mesh.faces) std::swap(face[0], face[1]);
  EXPECT_THROW(CheckMeshIsSeen(scene, mesh, "mesh.ply"), InputError);
  scene.views[0].camera = test::LookAt({0.5, 0.7, 6}, {0, 0, 12}, 320, 240, 300);
  EXPECT_THROW(CheckMeshIsSeen(scene, mesh, "mesh.ply"), InputError);
}

TEST(Refinement, BadOptionsAreNamed) {
  PipelineOptions options;
  options.photo.window = 4;
  try {
    RunPipeline(Relief().scene, Relief().init, options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "photo.window = 4: must be odd");
  }
  options.photo.window = 5;
  options.smooth.weight = -1;
  EXPECT_THROW(RunPipeline(Relief().scene, Relief().init, options), InputError);
}

}  // namespace
}  // namespace burin
