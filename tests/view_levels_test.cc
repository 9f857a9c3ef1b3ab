// Photographs of different sizes in one scene: levels are a view's own.
#include "core/refine/view_levels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/run/memory_estimate.h"
#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/colmap.h"
#include "core/synthetic/synthetic.h"
#include "tests/program_test.h"
#include "tests/split_facets.h"

namespace burin {
namespace {

using testing::HasSubstr;

// Relief, seen by nine views.
SyntheticScene Nine(int width, int height) {
  SyntheticOptions options;
  options.views = 9;
  options.width = width;
  options.height = height;
  options.samples_per_axis = 2;
  options.truth_point_count = 1000;
  options.point_count = 500;
  return MakeSyntheticScene(options);
}

// The photograph at another size, and its camera.
void Shrink(int width, int height, View* view) {
  cv::Mat1f full;
  view->gray.convertTo(full, CV_32F);
  cv::Mat1f reduced;
  cv::resize(full, reduced, cv::Size(width, height), 0, 0, cv::INTER_AREA);
  reduced.convertTo(view->gray, CV_8U);
  view->camera = view->camera.Resized(width, height);
}

// The rows from `first` on.
void CropRows(int first, int count, View* view) {
  view->gray = view->gray.rowRange(first, first + count).clone();
  view->camera.cy -= first;
  view->camera.height = count;
}

// Every other photograph at a quarter of its size.
SyntheticScene HalfOfThemSmall(int width, int height) {
  SyntheticScene mixed = Nine(width, height);
  for (size_t i = 0; i < 9; i += 2) Shrink(width / 4, height / 4, &mixed.scene.views[i]);
  return mixed;
}

// The same, and one more still smaller.
SyntheticScene ManySizes() {
  SyntheticScene mixed = HalfOfThemSmall(320, 240);
  Shrink(42, 32, &mixed.scene.views[3]);
  return mixed;
}
constexpr int kManySizesSide =
    50;  // level.min_side_px for two levels, the coarser without the smallest

std::vector<int> Halvings(const std::vector<ViewAtLevel>& views) {
  std::vector<int> halvings;
  halvings.reserve(views.size());
  for (const ViewAtLevel& view : views) halvings.push_back(view.halvings);
  return halvings;
}

std::vector<int> LevelsOf(const PipelineResult& result) {
  std::vector<int> levels;
  for (const LevelSummary& level : result.refinement.levels) levels.push_back(level.level);
  return levels;
}

double RmsePx(const SyntheticScene& scene, const TriangleMesh& mesh) {
  return RmseToTruthMesh(mesh, scene.truth, 20000) / scene.footprint;
}

TEST(ViewLevels, ViewsAreHalvedToLikeFootprints) {
  SyntheticScene mixed = Nine(320, 240);
  std::vector<View>& views = mixed.scene.views;
  Shrink(160, 120, &views[1]);
  Shrink(80, 60, &views[2]);
  Shrink(40, 30, &views[3]);
  CropRows(100, 40, &views[4]);
  LevelOptions options;
  options.min_side_px = 32;
  const ViewLevels levels(mixed.scene, mixed.init, options);
  EXPECT_EQ(Halvings(levels.At(0)), std::vector<int>(9, 0));
  EXPECT_EQ(Halvings(levels.At(1)), (std::vector<int>{1, 1, 0, 0, 1, 1, 1, 1, 1}));
  EXPECT_EQ(Halvings(levels.At(3)), (std::vector<int>{3, 3, 2, 1, 3, 3, 3, 3, 3}));
  for (const ViewAtLevel& view : levels.At(0)) EXPECT_TRUE(view.takes_part);
  const std::vector<ViewAtLevel> first = levels.At(1);
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(first[i].takes_part, i != 3 && i != 4) << i;
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(first[i].coarse, i == 2 || i == 3) << i;
  // Where all see alike, a level is what it says.
  const SyntheticScene even = Nine(160, 120);
  EXPECT_EQ(Halvings(ViewLevels(even.scene, even.init, LevelOptions()).At(2)),
            std::vector<int>(9, 2));
}

TEST(ViewLevels, ALevelNeedsHalfOfThePairsAndOneToJudgeIt) {
  SyntheticScene scene = Nine(384, 288);
  Shrink(96, 72, &scene.scene.views[0]);
  LevelOptions options;
  options.min_side_px = 73;
  const ViewLevels levels(scene.scene, scene.init, options);
  const CameraPair with = {0, 1};
  const CameraPair without = {2, 1};
  EXPECT_EQ(levels.Coarsest({without}, {}), 1);
  EXPECT_EQ(levels.Coarsest({with, without}, {}), 1);
  EXPECT_EQ(levels.Coarsest({with, without, with}, {}), 0);
  EXPECT_EQ(levels.Coarsest({without}, {with}), 0);
  EXPECT_EQ(levels.Coarsest({without}, {with, without}), 1);
}

// A photograph of 84x63 among nine once left one level of three: 1.85 px instead of 0.10. So did a strip.
TEST(ViewLevels, OneSmallPhotographCostsNoLevel) {
  SyntheticScene whole = Nine(384, 288);
  whole.scene.tracks = Tracks();  // view 4 is another one below
  SyntheticScene without = whole;
  without.scene.views.erase(without.scene.views.begin() + 4);
  without.scene.points.clear();
  const auto rmse = [&](const SyntheticScene& scene) {
    const PipelineResult result = RunPipeline(scene.scene, scene.init, test::SplitFacets());
    EXPECT_EQ(LevelsOf(result), (std::vector<int>{2, 1, 0}));
    const auto views = static_cast<int>(scene.scene.views.size());
    EXPECT_EQ(result.refinement.levels[0].views, 8);
    EXPECT_EQ(result.refinement.levels[2].views, views);
    return RmsePx(scene, result.mesh);
  };
  const double reached = rmse(without);
  SyntheticScene small = whole;
  Shrink(84, 63, &small.scene.views[4]);
  EXPECT_LT(rmse(small), 1.05 * reached);
  SyntheticScene strip = whole;
  CropRows(124, 40, &strip.scene.views[4]);
  EXPECT_LT(rmse(strip), 1.05 * reached);
}

// Zooms that differ by four: without a level on which pixels are alike, 1.03 px.
TEST(ViewLevels, PhotographsOfFourTimesTheSizeMeetOnALevel) {
  const SyntheticScene mixed = HalfOfThemSmall(640, 480);
  const PipelineResult result = RunPipeline(mixed.scene, mixed.init, test::SplitFacets());
  EXPECT_EQ(LevelsOf(result), (std::vector<int>{1, 0}));
  EXPECT_EQ(result.refinement.levels[0].views, 9);
  EXPECT_EQ(result.refinement.levels[0].views_halved_less, 5);
  EXPECT_LT(RmsePx(mixed, result.mesh), 0.25);
}

// Whatever the number of threads, and from every state that a run can go on from.
TEST(ViewLevels, TheBytesAreTheSame) {
  const SyntheticScene scene = ManySizes();
  PipelineOptions options;
  options.refinement.level.min_side_px = kManySizesSide;
  options.refinement.solver.max_iterations = 3;
  options.threads = 1;
  std::vector<std::vector<uint8_t>> states;
  PipelineParts parts;
  parts.observers.on_state = [&](const RefinementState& state) {
    states.push_back(StateBytes(state));
  };
  const PipelineResult whole = RunPipeline(scene.scene, scene.init, options, parts);
  EXPECT_EQ(whole.refinement.levels[0].views, 8);
  EXPECT_EQ(whole.refinement.levels[0].views_halved_less, 5);
  ASSERT_EQ(states.size(), 5U);  // after each of 4 + 2 rounds but the last
  options.threads = 3;
  for (const std::vector<uint8_t>& bytes : states) {
    const RefinementState state = StateFromBytes(bytes);
    PipelineParts rest;
    rest.start = &state;
    const PipelineResult resumed = RunPipeline(scene.scene, scene.init, options, rest);
    EXPECT_EQ(resumed.mesh.vertices, whole.mesh.vertices) << state.level << " " << state.round;
    EXPECT_EQ(resumed.mesh.faces, whole.mesh.faces);
  }
}

// The images of a level are counted at the size that they have there.
TEST(ViewLevels, TheMemoryEstimateKnowsThem) {
  const SyntheticScene mixed = HalfOfThemSmall(320, 240);
  PipelineOptions options;
  options.refinement.level.finest = 1;
  options.refinement.level.count = 1;
  const MemoryEstimate estimate = EstimateMemory(
      mixed.scene, mixed.init, LookAtSurface(mixed.scene, mixed.init), options, /*held_bytes=*/0);
  const double big = 4 * 320 * 240;
  const double small = 5 * 80 * 60;
  const double image_bytes = 4 + 4 * 1.05;  // reduced, and as spline coefficients
  EXPECT_EQ(estimate.parts[2].first, "images");
  EXPECT_NEAR(estimate.parts[2].second * 1024 * 1024, big + small + (big / 4 + small) * image_bytes,
              100e3);
}

using ViewLevelsProgram = ProgramTest;

TEST_F(ViewLevelsProgram, LogAndSummarySayWhoTakesPart) {
  const SyntheticScene scene = ManySizes();
  WriteColmapScene(scene.scene, In("scene"), /*binary=*/true);
  WriteMesh(In("init.ply"), scene.init);
  const Outcome run =
      Run({"refine", In("scene"), "--mesh", In("init.ply"), "--output", In("out"),
           "--solver.max_iterations", "2", "--level.min_side_px", std::to_string(kManySizesSide)});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("level 160x120: left out, too small here (level.min_side_px): "
                                 "view_003.png; reduced less than the others, as their pixels are "
                                 "coarser: view_000.png, view_002.png, view_004.png and 2 more\n"));
  EXPECT_THAT(run.err, HasSubstr("level 320x240 round 1"));
  const auto summary = nlohmann::json::parse(ReadAll(In("out/summary.json")));
  EXPECT_EQ(summary["levels"][0]["views"]["taking_part"], 8);
  EXPECT_EQ(summary["levels"][0]["views"]["halved_less"], 5);
  EXPECT_EQ(summary["levels"][1]["views"]["taking_part"], 9);
  EXPECT_EQ(summary["levels"][1]["views"]["halved_less"], 0);
}

}  // namespace
}  // namespace burin
