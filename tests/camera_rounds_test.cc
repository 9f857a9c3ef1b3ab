// Rounds that move the cameras with the surface, in whole refinements.
#include "core/refine/camera_rounds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/cameras_output.h"
#include "apps/run/pipeline.h"
#include "core/scene/camera_similarity.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/seen_points.h"
#include "tests/small_relief.h"
#include "tests/split_facets.h"

namespace burin {
namespace {

// A relief seen by cameras that are off by a pixel, and by the true ones.
struct Scenes {
  SyntheticScene exact;
  SyntheticScene noisy;
};

const Scenes& Relief() {
  static const auto* scenes = [] {
    SyntheticOptions options = test::SmallReliefOptions(7);
    auto* made = new Scenes;
    made->exact = MakeSyntheticScene(options);
    options.pose_noise_px = 1;
    made->noisy = MakeSyntheticScene(options);
    return made;
  }();
  return *scenes;
}

double Error(const std::vector<Camera>& cameras) {
  const SyntheticScene& exact = Relief().exact;
  CameraSimilarity fit;
  std::string error;
  EXPECT_TRUE(FitCameraSimilarity(CamerasOf(exact.scene), cameras,
                                  SeenPoints(exact.truth, exact.scene.views), &fit, &error))
      << error;
  return fit.errors.rms_px;
}

PipelineOptions Options(CameraSteps steps) {
  PipelineOptions options = test::SplitFacets();
  options.refinement.cameras.refine = CameraUnknowns::kPoses;
  options.refinement.cameras.steps = steps;
  options.refinement.cameras.finest_joint = 0;
  options.refinement.cameras.joint_rounds = 10;
  options.refinement.level.count = 2;
  options.refinement.solver.max_iterations = 6;
  return options;
}

PipelineResult Refined(const PipelineOptions& options, const PipelineParts& given = {}) {
  PipelineParts parts = given;
  parts.measure_quality = false;
  return RunPipeline(Relief().noisy.scene, Relief().noisy.init, options, parts);
}

bool Same(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  for (size_t v = 0; v < a.size(); ++v) {
    if (a[v].rotation != b[v].rotation || a[v].translation != b[v].translation) return false;
  }
  return a.size() == b.size();
}

TEST(CameraRounds, TakeTheErrorAwayWithTheSurface) {
  const double before = Error(CamerasOf(Relief().noisy.scene));
  const PipelineResult result = Refined(Options(CameraSteps::kJoint));
  EXPECT_GT(before, 1);
  EXPECT_LT(Error(result.refinement.cameras), 0.1 * before);
  bool moved = false;
  for (const LevelSummary& level : result.refinement.levels) {
    for (const RoundSummary& round : level.rounds) {
      const bool last = round.round + 1 == static_cast<int>(level.rounds.size());
      EXPECT_EQ(round.camera_px > 0, !last);
      moved = moved || round.camera_px > 0;
    }
  }
  EXPECT_TRUE(moved);
}

// The rounds on facets cut anew are those that move the surface alone.
TEST(CameraRounds, OfTheFinestLevelAreBeforeItsSurfaceIsCutAnew) {
  PipelineOptions options = Options(CameraSteps::kJoint);
  options.refinement.surface.remesh = SurfaceFacets::kAdapted;
  options.refinement.level.count = 1;
  const PipelineResult result = Refined(options);
  const std::vector<LevelSummary>& levels = result.refinement.levels;
  ASSERT_GE(levels.size(), 2U);
  for (const LevelSummary& level : levels) {
    ASSERT_EQ(level.rounds.size(), 1U);
    EXPECT_EQ(level.rounds[0].camera_px > 0, &level == &levels[0]);
  }
}

TEST(CameraRounds, LeaveCamerasAloneUnlessAsked) {
  PipelineOptions options = Options(CameraSteps::kBoth);
  options.refinement.cameras.refine = CameraUnknowns::kNone;
  EXPECT_TRUE(Same(Refined(options).refinement.cameras, CamerasOf(Relief().noisy.scene)));
}

TEST(CameraRounds, AreTheSameOnAnyNumberOfThreads) {
  PipelineOptions options = Options(CameraSteps::kJoint);
  options.threads = 1;
  const PipelineResult one = Refined(options);
  options.threads = 2;
  const PipelineResult two = Refined(options);
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  EXPECT_TRUE(Same(one.refinement.cameras, two.refinement.cameras));
}

// Joint rounds, and tracks whose cameras small images leave alone.
TEST(CameraRounds, ARunThatGoesOnComesToTheSameBytes) {
  for (const CameraSteps steps : {CameraSteps::kJoint, CameraSteps::kBoth}) {
    const PipelineOptions options = Options(steps);
    std::vector<std::vector<uint8_t>> states;
    PipelineParts parts;
    parts.observers.on_state = [&](const RefinementState& state) {
      states.push_back(StateBytes(state));
    };
    const PipelineResult whole = Refined(options, parts);
    ASSERT_GE(states.size(), 4U);
    for (const size_t k : {size_t{0}, states.size() / 2, states.size() - 1}) {
      const RefinementState start = StateFromBytes(states[k]);
      PipelineParts rest;
      rest.start = &start;
      rest.tracks_hold_all = whole.by_tracks.has_value() && whole.by_tracks->HoldsAllViews();
      const PipelineResult result = Refined(options, rest);
      EXPECT_EQ(result.mesh.vertices, whole.mesh.vertices) << k;
      EXPECT_TRUE(Same(result.refinement.cameras, whole.refinement.cameras)) << k;
    }
  }
}

// The program's way of telling a run that goes on: through the checkpoint's JSON.
TEST(CameraRounds, SmallImagesLeaveCamerasOfTracksAlone) {
  std::vector<std::string> lines;
  PipelineParts parts;
  parts.on_small_levels = [&](const SmallLevels& small) {
    lines.push_back(SmallLevelsText(small));
  };
  parts.measure_quality = false;
  SyntheticOptions size = test::SmallReliefOptions(5);
  size.width = 480;
  size.height = 360;
  size.pose_noise_px = 1;
  const SyntheticScene noisy = MakeSyntheticScene(size);
  PipelineOptions options = Options(CameraSteps::kBoth);
  options.refinement.level.finest = 1;
  const PipelineResult result = RunPipeline(noisy.scene, noisy.init, options, parts);
  ASSERT_TRUE(result.by_tracks.has_value());
  ASSERT_TRUE(result.by_tracks->HoldsAllViews());
  EXPECT_TRUE(Same(result.refinement.cameras, result.by_tracks->cameras));
  EXPECT_EQ(lines, std::vector<std::string>{
                       "cameras: no joint rounds where images are below 320 px (level 1: 240 px): "
                       "tracks tell cameras better there"});
  const Scene& scene = noisy.scene;
  EXPECT_TRUE(HoldsAllViews(TrackStepJson(*result.by_tracks, scene).dump()));
  EXPECT_FALSE(HoldsAllViews(""));
  TrackStep other = *result.by_tracks;
  other.groups[0].kept = false;
  EXPECT_FALSE(HoldsAllViews(TrackStepJson(other, scene).dump()));
  other.groups = {result.by_tracks->groups[0], result.by_tracks->groups[0]};
  EXPECT_FALSE(other.HoldsAllViews());  // joint rounds tell how groups lie to each other
  other.groups.pop_back();
  other.groups[0].views.pop_back();
  EXPECT_FALSE(other.HoldsAllViews());
}

TEST(CameraRounds, LargeImagesStay) {
  SyntheticOptions size = test::SmallReliefOptions(4);
  size.width = 640;
  size.height = 480;
  const SyntheticScene scene = MakeSyntheticScene(size);
  const ViewLevels levels(scene.scene, scene.init, LevelOptions());
  CamerasOptions options;
  EXPECT_FALSE(LeaveOutSmallLevels(scene.scene, levels, 3, &options).Any());
  EXPECT_TRUE(MovesCameras(options, 1, 0, 3));
  options.coarsest_joint = 3;
  options.finest_joint = 0;
  const SmallLevels small = LeaveOutSmallLevels(scene.scene, levels, 2, &options);
  EXPECT_EQ(small.finest, 2);
  EXPECT_EQ(small.side_px, 160);
  EXPECT_FALSE(MovesCameras(options, 2, 0, 3));
  EXPECT_TRUE(MovesCameras(options, 1, 0, 3));
  EXPECT_TRUE(MovesCameras(options, 0, 0, 3));
  options = CamerasOptions();
  options.coarsest_joint = options.finest_joint = 2;
  EXPECT_TRUE(LeaveOutSmallLevels(scene.scene, levels, 2, &options).Any());
  EXPECT_FALSE(options.Jointly());
}

TEST(CameraRounds, AnyStrategyComesWithThem) {
  const double before = Error(CamerasOf(Relief().noisy.scene));
  for (const char* type : {"lbfgs", "gradient_descent", "lbfgs_h", "lm_cholesky"}) {
    PipelineOptions options = Options(CameraSteps::kJoint);
    options.refinement.solver.type = type;
    EXPECT_LT(Error(Refined(options).refinement.cameras), 0.5 * before) << type;
  }
}

// A view that is turned by a degree has not moved the others' world, after tracks and after joint rounds.
TEST(CameraRounds, AViewThatIsFarOffDoesNotHoldTheFrame) {
  SyntheticOptions size = test::SmallReliefOptions(7);
  size.width = 480;
  size.height = 360;
  const SyntheticScene exact = MakeSyntheticScene(size);
  SyntheticScene turned = exact;
  Camera& camera = turned.scene.views[3].camera;
  const Eigen::Vector3d center = camera.Center();
  camera.rotation =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 1, 0).normalized()).matrix() * camera.rotation;
  camera.translation = -(camera.rotation * center);
  PipelineParts parts;
  parts.measure_quality = false;
  const PipelineResult result =
      RunPipeline(turned.scene, turned.init, Options(CameraSteps::kBoth), parts);
  ASSERT_TRUE(result.by_tracks.has_value());
  EXPECT_EQ(result.by_tracks->misregistered, std::vector<int>{3});
  const CameraErrors errors = MeasureCameraErrors(
      result.refinement.cameras,
      SightingsOf(CamerasOf(exact.scene), SeenPoints(exact.truth, exact.scene.views)),
      Similarity());
  for (size_t v = 0; v < errors.view_px.size(); ++v) EXPECT_LT(errors.view_px[v], 0.3) << v;
}

// Finds every level worse.
class StrictJudge : public LevelJudge {
 public:
  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext&, const TermRounds&, LevelFacets /*facets*/,
                  const nlohmann::json& /*report*/) override {}
  LevelVerdict EndLevel(const RoundContext&, const TermRounds&,
                        const TriangleMesh& after) override {
    return {std::vector<char>(after.vertices.size(), 1), {}};
  }

 private:
  std::vector<CameraPair> pairs_;
};

TEST(CameraRounds, AreUndoneWithTheirLevel) {
  StrictJudge judge;
  PipelineParts parts;
  parts.judge = &judge;
  const PipelineResult result = Refined(Options(CameraSteps::kJoint), parts);
  EXPECT_TRUE(Same(result.refinement.cameras, CamerasOf(Relief().noisy.scene)));
  for (size_t v = 0; v < Relief().noisy.init.vertices.size(); ++v) {
    EXPECT_LT((result.mesh.vertices[v] - Relief().noisy.init.vertices[v]).norm(),
              1e-9 * Relief().noisy.footprint + 1e-12);
  }
}

// Centroid, turn and size of the world stay: no similarity brings the surface's image nearer to that of the cameras given
// than none. (How the world is turned is told by the surface seen: here by a tenth of a degree.)
TEST(CameraRounds, TheFrameIsTheInputs) {
  const PipelineResult result = Refined(Options(CameraSteps::kJoint));
  const std::vector<Camera> given = CamerasOf(Relief().noisy.scene);
  const auto points = SeenPoints(Relief().noisy.init, Relief().noisy.scene.views);
  CameraSimilarity fit;
  std::string error;
  ASSERT_TRUE(FitCameraSimilarity(given, result.refinement.cameras, points, &fit, &error));
  EXPECT_NEAR(fit.second_from_first.scale, 1, 2e-4);
  EXPECT_LT(fit.second_from_first.AngleDeg(), 0.2);
  const CameraErrors still =
      MeasureCameraErrors(result.refinement.cameras, SightingsOf(given, points), Similarity());
  EXPECT_LT(still.rms_px, 1.02 * fit.errors.rms_px);
}

}  // namespace
}  // namespace burin
