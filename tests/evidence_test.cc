// What photographs show nothing of stays as it is: vertices, parts of the mesh, levels.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/refine/round.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic.h"
#include "costs/held_back.h"
#include "tests/small_relief.h"
#include "tests/split_facets.h"

namespace burin {
namespace {

const SyntheticScene& Relief() {
  static const auto* scene = new SyntheticScene(MakeSyntheticScene(test::SmallReliefOptions(7)));
  return *scene;
}

double PixelsPerUnit() { return 1 / Relief().footprint; }

// A bent strip along x before the relief, `width_px` pixels wide, facing the cameras.
TriangleMesh Strip(double width_px) {
  constexpr int kSteps = 40;
  const double pixel = Relief().footprint;
  TriangleMesh strip;
  for (int k = 0; k <= kSteps; ++k) {
    for (const double side : {-0.5, 0.5}) {
      strip.vertices.emplace_back((3 * k - 1.5 * kSteps) * pixel, side * width_px * pixel,
                                  (40 + std::sin(0.7 * k)) * pixel);
    }
  }
  for (int k = 0; k < kSteps; ++k) {
    strip.faces.emplace_back(2 * k, 2 * k + 2, 2 * k + 3);
    strip.faces.emplace_back(2 * k, 2 * k + 3, 2 * k + 1);
  }
  return strip;
}

void Append(const TriangleMesh& part, TriangleMesh* mesh) {
  const auto first = static_cast<int>(mesh->vertices.size());
  mesh->vertices.insert(mesh->vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const Eigen::Vector3i& face : part.faces) {
    mesh->faces.emplace_back(face[0] + first, face[1] + first, face[2] + first);
  }
}

// Seen by pairs, but too thin for a window on any level, beside a half of the relief. (Smoothness alone moved it by
// 5.7 px when a pixel was evidence enough.)
TEST(Evidence, AStripWithoutAWholeWindowKeepsItsShape) {
  TriangleMesh strip = Strip(2);
  for (Eigen::Vector3d& vertex : strip.vertices) vertex.x() -= 0.6;
  TriangleMesh mesh = Relief().init;
  mesh.faces.clear();
  for (const Eigen::Vector3i& face : Relief().init.faces) {
    double left = 1;
    for (const int v : face) left = std::min(left, mesh.vertices[v].x());
    if (left > 0.1) mesh.faces.push_back(face);
  }
  const auto first = mesh.vertices.size();
  Append(strip, &mesh);
  PipelineParts parts;
  int seen = 0;
  parts.observers.on_round = [&](const RoundContext& context, const TriangleMesh& /*now*/,
                                 const RoundSummary& round) {
    const auto all = std::count(context.seen.begin(), context.seen.end(), 1);
    const auto strip_vertices = static_cast<long>(strip.vertices.size());
    EXPECT_EQ(std::count(context.supported.begin(), context.supported.end(), 1),
              round.supported_vertices);
    EXPECT_LT(round.supported_vertices, all - strip_vertices / 2);
    ++seen;
  };
  const PipelineResult result = RunPipeline(Relief().scene, mesh, test::SplitFacets(), parts);
  EXPECT_GE(seen, 2);
  double moved = 0;
  for (size_t v = 0; v < strip.vertices.size(); ++v) {
    moved = std::max(moved, (result.mesh.vertices[first + v] - strip.vertices[v]).norm());
  }
  EXPECT_LT(moved * PixelsPerUnit(), 1e-6);
  double relief_moved = 0;
  for (size_t v = 0; v < first; ++v) {
    relief_moved = std::max(relief_moved, (result.mesh.vertices[v] - mesh.vertices[v]).norm());
  }
  EXPECT_GT(relief_moved * PixelsPerUnit(), 1);
}

// Five pixels wide, two or three at half size: whole windows at full size only.
TEST(Evidence, LevelsWithoutAWindowAreLeftOut) {
  const PipelineResult result = RunPipeline(Relief().scene, Strip(5), test::SplitFacets());
  const std::vector<LevelSummary>& levels = result.refinement.levels;
  ASSERT_EQ(levels.size(), 2U);
  EXPECT_TRUE(levels[0].left_out);
  EXPECT_TRUE(levels[0].rounds.empty());
  EXPECT_TRUE(levels[0].held_back.is_null());
  EXPECT_FALSE(levels[1].left_out);
  // The rounds of the level that it takes the place of.
  const LevelOptions options;
  EXPECT_EQ(static_cast<int>(levels[1].rounds.size()), options.RoundsAt(1));
}

// Rods of 1 to 3 px, with no window at half size. (Smoothed on every level, they shrank.)
TEST(Evidence, RodsGainAndKeepTheirLength) {
  SyntheticOptions options;
  options.scene = SyntheticKind::kRods;
  options.width = 320;
  options.height = 240;
  options.samples_per_axis = 2;
  const SyntheticScene rods = MakeSyntheticScene(options);
  const PipelineResult result = RunPipeline(rods.scene, rods.init, PipelineOptions());
  const auto f1 = [&](const TriangleMesh& mesh) {
    Truth truth;
    truth.cloud.points = rods.truth_points;
    EvaluationOptions evaluation;
    evaluation.tau = "0.5,1";
    evaluation.unit = rods.footprint;
    evaluation.sample_count = 50000;
    const Evaluation scored = EvaluateMesh(mesh, truth, evaluation);
    return std::array<double, 2>{scored.scores[0].f1, scored.scores[1].f1};
  };
  const std::array<double, 2> before = f1(rods.init);
  const std::array<double, 2> after = f1(result.mesh);
  RecordProperty("f1_half_px", std::to_string(before[0]) + " " + std::to_string(after[0]));
  EXPECT_GT(after[0], before[0] + 0.05);
  EXPECT_GT(after[1], before[1] + 0.05);
  ASSERT_EQ(ConnectedComponents(result.mesh).size(), ConnectedComponents(rods.init).size());
  // Every rod, told by its middle, as its facets are others.
  const auto boxes = [](const TriangleMesh& mesh) {
    std::vector<Eigen::AlignedBox3d> found;
    for (const std::vector<int>& part : ConnectedComponents(mesh)) {
      Eigen::AlignedBox3d box;
      for (const int f : part) {
        for (const int v : mesh.faces[f]) box.extend(mesh.vertices[v]);
      }
      found.push_back(box);
    }
    return found;
  };
  const std::vector<Eigen::AlignedBox3d> ends = boxes(result.mesh);
  for (const Eigen::AlignedBox3d& start : boxes(rods.init)) {
    const auto off = [&](const Eigen::AlignedBox3d& box) {
      return (box.center() - start.center()).norm();
    };
    const Eigen::AlignedBox3d& end = *std::min_element(
        ends.begin(), ends.end(), [&](const auto& a, const auto& b) { return off(a) < off(b); });
    EXPECT_LT(off(end), 2 * rods.footprint);
    EXPECT_NEAR(end.diagonal().norm(), start.diagonal().norm(), 3 * rods.footprint);
  }
}

TEST(Evidence, NoWindowOnAnyLevelIsAnError) {
  try {
    RunPipeline(Relief().scene, Strip(2), PipelineOptions());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("at any level"), std::string::npos) << error.what();
  }
}

// Two halves of the relief with a gap between them.
TriangleMesh Halves() {
  const TriangleMesh& truth = Relief().truth;
  TriangleMesh halves;
  halves.vertices = truth.vertices;
  const auto count = static_cast<int>(truth.vertices.size());
  halves.vertices.insert(halves.vertices.end(), truth.vertices.begin(), truth.vertices.end());
  for (const Eigen::Vector3i& face : truth.faces) {
    const bool right = truth.vertices[face[0]].x() + truth.vertices[face[1]].x() > 0;
    halves.faces.push_back(right ? (face.array() + count).matrix().eval() : face);
  }
  for (Eigen::Vector3d& vertex : halves.vertices) vertex /= Relief().footprint;
  return halves;
}

// Half of the mesh gets better, the other one worse by less: the sum is better.
TEST(Evidence, APartIsJudgedByItself) {
  const TriangleMesh truth = Halves();
  ASSERT_EQ(ConnectedComponents(truth).size(), 2U);
  const auto middle = truth.vertices.size() / 2;
  TriangleMesh before = truth;
  TriangleMesh after = truth;
  for (size_t v = 0; v < truth.vertices.size(); ++v) {
    const double ripple = std::sin(truth.vertices[v].x() / 6);
    if (v < middle) {
      before.vertices[v].z() += 1.5 * ripple;
    } else {
      after.vertices[v].z() += 0.7 * ripple;
    }
  }
  const std::vector<LevelView> views =
      MakeLevelViews(Relief().scene, 0, Eigen::Vector3d::Zero(), 1 / Relief().footprint);
  PhotometricEnergy photometric((PhotometricOptions()));
  photometric.BeginLevel(views);
  HeldBackJudge judge({{1, 3}, {2, 4}, {3, 5}}, &photometric);
  const auto context_of = [&](const TriangleMesh& mesh, std::vector<ViewDomain>* domains,
                              std::vector<ViewPartners>* held_back) {
    return FreezeRound(views, {{2, 3}, {3, 2}}, mesh, Motion::kNormal, 3, domains,
                       judge.HeldBackPairs(), held_back);
  };
  std::vector<ViewDomain> domains[2];
  std::vector<ViewPartners> held_back[2];
  const RoundContext first = context_of(before, &domains[0], &held_back[0]);
  judge.BeginLevel(first, TermRounds({&photometric}, first), LevelFacets::kSame, nullptr);
  const RoundContext last = context_of(after, &domains[1], &held_back[1]);
  const LevelVerdict verdict = judge.EndLevel(last, TermRounds({&photometric}, last), after);
  EXPECT_LT(verdict.report["after"], verdict.report["before"]);
  for (const Eigen::Vector3i& face : truth.faces) {
    for (const int v : face) {
      ASSERT_EQ(verdict.undo[v] != 0, static_cast<size_t>(v) >= middle) << v;
    }
  }
}

// What the judge says is set back goes back, with what counts as seen; the rest stays.
TEST(Evidence, PartsAreSetBack) {
  class Judge : public LevelJudge {
   public:
    const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
    void BeginLevel(const RoundContext& first, const TermRounds& /*terms*/, LevelFacets /*facets*/,
                    const nlohmann::json& /*report*/) override {
      before_ = *first.mesh;
    }
    LevelVerdict EndLevel(const RoundContext& /*last*/, const TermRounds& /*terms*/,
                          const TriangleMesh& after) override {
      LevelVerdict verdict;
      for (const Eigen::Vector3d& vertex : before_.vertices) {
        verdict.undo.push_back(vertex.x() > 0 ? 1 : 0);
      }
      EXPECT_EQ(verdict.undo.size(), after.vertices.size());
      return verdict;
    }

   private:
    const std::vector<CameraPair> pairs_ = {{2, 5}};
    TriangleMesh before_;
  };
  Judge judge;
  PipelineOptions options = test::SplitFacets();
  options.refinement.level.count = 1;
  options.refinement.guard.levels = false;
  PipelineParts parts;
  parts.judge = &judge;
  const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options, parts);
  ASSERT_EQ(result.refinement.levels.size(), 1U);
  const LevelSummary& level = result.refinement.levels[0];
  EXPECT_FALSE(level.undone);
  EXPECT_GT(level.undone_vertices, 20);
  EXPECT_LT(level.undone_vertices, level.vertices);
  int moved = 0;
  for (size_t v = 0; v < Relief().init.vertices.size(); ++v) {
    const Eigen::Vector3d& start = Relief().init.vertices[v];
    const double distance = (result.mesh.vertices[v] - start).norm() * PixelsPerUnit();
    if (start.x() > 1e-3 * Relief().footprint) {
      EXPECT_LT(distance, 1e-9);
    } else if (distance > 0.1) {
      ++moved;
    }
  }
  EXPECT_GT(moved, 10);
}

}  // namespace
}  // namespace burin
