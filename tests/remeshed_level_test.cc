// The finest level once more on a surface that is cut anew: one transaction of the guard, with all that a vertex knows.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/evaluate/mesh_shape.h"
#include "core/refine/level_judge.h"
#include "core/refine/normalized_world.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "tests/small_relief.h"

namespace burin {
namespace {

const SyntheticScene& Relief() {
  static const auto* scene = new SyntheticScene(MakeSyntheticScene(test::SmallReliefOptions(7)));
  return *scene;
}

PipelineOptions Options(SurfaceFacets remesh) {
  PipelineOptions options;
  options.refinement.level.count = 2;
  options.refinement.surface.remesh = remesh;
  options.refinement.surface.rounds = 2;
  options.refinement.surface.chord_px = 0.04;  // the relief is rough
  return options;
}

PipelineResult Refined(const PipelineOptions& options, const PipelineParts& parts = {}) {
  return RunPipeline(Relief().scene, Relief().init, options, parts);
}

TEST(RemeshedLevel, HasFewerAndBetterFacetsAndAsGoodASurface) {
  const PipelineResult plain = Refined(Options(SurfaceFacets::kNone));
  const PipelineResult result = Refined(Options(SurfaceFacets::kAdapted));
  ASSERT_EQ(plain.refinement.levels.size(), 2U);
  ASSERT_EQ(result.refinement.levels.size(), 3U);
  const LevelSummary& level = result.refinement.levels.back();
  EXPECT_EQ(level.level, 0);
  EXPECT_EQ(static_cast<size_t>(level.remeshed_faces), plain.mesh.faces.size());
  EXPECT_EQ(static_cast<size_t>(level.faces), result.mesh.faces.size());
  EXPECT_FALSE(level.undone);
  EXPECT_EQ(level.rounds.size(), 2U);
  EXPECT_EQ(level.rounds[0].round, 1);  // of the level's
  EXPECT_LT(result.mesh.faces.size(), 0.9 * plain.mesh.faces.size());
  EXPECT_GT(ShapeOf(result.mesh).quality, 0.94);
  EXPECT_LT(ShapeOf(plain.mesh).quality, 0.9);
  const double before = RmseToTruthMesh(plain.mesh, Relief().truth, 20000);
  const double after = RmseToTruthMesh(result.mesh, Relief().truth, 20000);
  EXPECT_LT(after, 1.1 * before);
  std::printf("%zu -> %zu facets, quality %.3f -> %.3f, rmse %.3f -> %.3f px\n",
              plain.mesh.faces.size(), result.mesh.faces.size(), ShapeOf(plain.mesh).quality,
              ShapeOf(result.mesh).quality, before / Relief().footprint,
              after / Relief().footprint);
}

TEST(RemeshedLevel, KnowsWhereOnTheInputItLay) {
  PipelineParts parts;
  bool seen = false;
  parts.observers.on_end = [&](const RefinementEnd& end) {
    seen = true;
    TriangleMesh start{end.input_position, end.mesh->faces};
    const NormalizedWorld world = NormalizedWorld::Of(Relief().scene, Relief().init);
    // The input is flat between its vertices; facets that lie over its edges cut them short.
    EXPECT_LT(RmseToTruthMesh(world.ToWorld(std::move(start)), Relief().init, 20000),
              0.1 * Relief().footprint);
  };
  Refined(Options(SurfaceFacets::kAdapted), parts);
  EXPECT_TRUE(seen);
}

// Says no to the first levels on other facets.
class NoOtherFacets : public LevelJudge {
 public:
  explicit NoOtherFacets(int times) : times_(times) { pairs_.push_back({2, 5}); }
  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext& first, const TermRounds& /*terms*/, LevelFacets facets,
                  const nlohmann::json& /*report*/) override {
    other_ = facets == LevelFacets::kOther;
    if (other_) start_ = first.mesh->faces.size();
  }
  LevelVerdict EndLevel(const RoundContext& last, const TermRounds& /*terms*/,
                        const TriangleMesh& after) override {
    EXPECT_NE(last.held_back, nullptr);
    if (other_) {
      EXPECT_NE(start_, after.faces.size());
    }
    const bool no = other_ && times_-- > 0;
    return {std::vector<char>(after.vertices.size(), no ? 1 : 0), "said"};
  }

 private:
  std::vector<CameraPair> pairs_;
  int times_;
  bool other_ = false;
  size_t start_ = 0;
};

// The rounds that were kept for it are on the surface as it was.
TEST(RemeshedLevel, UndoneTwiceItIsAsGoodAsIfItNeverWas) {
  const auto run = [](SurfaceFacets remesh) {
    NoOtherFacets judge(/*times=*/2);
    PipelineParts parts;
    parts.judge = &judge;
    return Refined(Options(remesh), parts);
  };
  const PipelineResult plain = run(SurfaceFacets::kNone);
  const PipelineResult undone = run(SurfaceFacets::kAdapted);
  const std::vector<LevelSummary>& levels = undone.refinement.levels;
  ASSERT_EQ(levels.size(), 5U);
  EXPECT_TRUE(levels[2].undone);
  EXPECT_TRUE(levels[3].undone);
  EXPECT_FALSE(levels[4].undone);
  EXPECT_EQ(levels[4].remeshed_faces, 0);
  EXPECT_EQ(levels[1].rounds.size() + levels[4].rounds.size(),
            plain.refinement.levels[1].rounds.size());
  EXPECT_EQ(static_cast<size_t>(levels[4].faces), undone.mesh.faces.size());
  EXPECT_NEAR(static_cast<double>(undone.mesh.faces.size()),
              static_cast<double>(plain.mesh.faces.size()),
              0.01 * static_cast<double>(plain.mesh.faces.size()));
  EXPECT_NEAR(RmseToTruthMesh(undone.mesh, Relief().truth, 20000),
              RmseToTruthMesh(plain.mesh, Relief().truth, 20000), 0.005 * Relief().footprint);
}

TEST(RemeshedLevel, UndoneIsTriedOnceMoreWithFinerFacets) {
  NoOtherFacets judge(/*times=*/1);
  PipelineParts parts;
  parts.judge = &judge;
  const PipelineResult result = Refined(Options(SurfaceFacets::kAdapted), parts);
  const std::vector<LevelSummary>& levels = result.refinement.levels;
  ASSERT_EQ(levels.size(), 4U);
  EXPECT_TRUE(levels[2].undone);
  EXPECT_FALSE(levels[3].undone);
  EXPECT_EQ(levels[2].remeshed_faces, levels[3].remeshed_faces);
  EXPECT_EQ(static_cast<size_t>(levels[3].faces), result.mesh.faces.size());
  EXPECT_EQ(levels[3].rounds[0].round, 3);
}

TEST(RemeshedLevel, GoesOnFromEveryStateToTheSameBytes) {
  std::vector<std::vector<uint8_t>> states;
  PipelineParts parts;
  parts.observers.on_state = [&](const RefinementState& state) {
    if (state.stage != LevelStage::kGiven) states.push_back(StateBytes(state));
  };
  const PipelineResult whole = Refined(Options(SurfaceFacets::kAdapted), parts);
  ASSERT_EQ(states.size(), 2U);  // before its first round, and after it
  for (const std::vector<uint8_t>& bytes : states) {
    const RefinementState state = StateFromBytes(bytes);
    PipelineParts rest;
    rest.start = &state;
    const PipelineResult result = Refined(Options(SurfaceFacets::kAdapted), rest);
    EXPECT_EQ(result.mesh.vertices, whole.mesh.vertices);
    EXPECT_EQ(result.mesh.faces, whole.mesh.faces);
    EXPECT_EQ(result.refinement.levels.back().held_back["after"],
              whole.refinement.levels.back().held_back["after"]);
    EXPECT_EQ(result.refinement.levels.back().held_back["before"],
              whole.refinement.levels.back().held_back["before"]);
  }
}

TEST(RemeshedLevel, IsTheSameOnAnyNumberOfThreads) {
  PipelineOptions options = Options(SurfaceFacets::kAdapted);
  options.threads = 1;
  const PipelineResult one = Refined(options);
  options.threads = 2;
  const PipelineResult two = Refined(options);
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, two.mesh.faces);
}

}  // namespace
}  // namespace burin
