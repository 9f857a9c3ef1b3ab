// Faulty photographs: the refined mesh is not worse than the input.
#include <gtest/gtest.h>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/synthetic/synthetic.h"
#include "core/synthetic/synthetic_stress.h"

namespace burin {
namespace {

SyntheticOptions Small(SyntheticKind scene, StressKind stress) {
  SyntheticOptions options;
  options.scene = scene;
  options.stress = stress;
  options.views = 6;
  options.width = 240;
  options.height = 180;
  options.samples_per_axis = 2;
  options.init_edge_px = 24;
  options.truth_point_count = 50000;
  options.point_count = 500;
  return options;
}

using Case = std::tuple<SyntheticKind, StressKind>;
std::vector<StressKind> Stresses() {
  std::vector<StressKind> stresses;
  for (const auto& choice : ChoicesOf(StressKind())) stresses.push_back(choice.first);
  return stresses;
}

class HardPhotographs : public testing::TestWithParam<Case> {};

TEST_P(HardPhotographs, TheRefinedMeshIsNotWorse) {
  const auto& [scene, stress] = GetParam();
  const SyntheticScene synthetic = MakeSyntheticScene(Small(scene, stress));
  Truth seen;  // by two views and more
  seen.cloud.points = synthetic.truth_points;
  seen.cloud.normals = synthetic.truth_normals;
  EvaluationOptions options;
  options.unit = synthetic.footprint;
  options.tau = "0.5";
  options.max_distance = 10;
  options.sample_count = 50000;
  const Evaluation before = EvaluateMesh(synthetic.init, seen, options);
  const PipelineResult result = RunPipeline(synthetic.scene, synthetic.init, PipelineOptions());
  const Evaluation after = EvaluateMesh(result.mesh, seen, options);
  EXPECT_LE(after.accuracy.mean, before.accuracy.mean);
  EXPECT_LE(after.completeness.mean, before.completeness.mean);
  EXPECT_GE(after.completeness.MatchedShare(), before.completeness.MatchedShare() - 0.02);
  EXPECT_GE(after.scores[0].f1, before.scores[0].f1);
}

INSTANTIATE_TEST_SUITE_P(All, HardPhotographs,
                         testing::Combine(testing::Values(SyntheticKind::kRelief,
                                                          SyntheticKind::kOccluders),
                                          testing::ValuesIn(Stresses())),
                         [](const auto& test) {
                           return NameOf(std::get<0>(test.param)) + "_" +
                                  NameOf(std::get<1>(test.param));
                         });

// Each does what it says, and nothing else.
TEST(Stresses, ChangeWhatTheySay) {
  const SyntheticScene clean = MakeSyntheticScene(Small(SyntheticKind::kRelief, StressKind::kNone));
  const auto changed = [&](const SyntheticScene& scene, size_t view) {
    cv::Mat difference;
    cv::absdiff(scene.scene.views[view].gray, clean.scene.views[view].gray, difference);
    return cv::countNonZero(difference) / static_cast<double>(difference.total());
  };
  const SyntheticScene saturated =
      MakeSyntheticScene(Small(SyntheticKind::kRelief, StressKind::kSaturated));
  EXPECT_EQ(changed(saturated, 0), 0);
  EXPECT_NEAR(changed(saturated, 1), 1.0 / 3, 0.02);
  const cv::Mat part = saturated.scene.views[1].gray.colRange(0, 80);
  EXPECT_GT(cv::countNonZero(part == 255) / static_cast<double>(part.total()), 0.8);
  const SyntheticScene mover =
      MakeSyntheticScene(Small(SyntheticKind::kRelief, StressKind::kMover));
  for (size_t view = 0; view < 6; ++view) {
    const double disc = 3.14159 / 64 * 180 / 240;  // radius an eighth of the height
    EXPECT_NEAR(changed(mover, view), view == 2 || view == 3 ? disc : 0, 0.1 * disc) << view;
  }
  const SyntheticScene pose = MakeSyntheticScene(Small(SyntheticKind::kRelief, StressKind::kPose));
  for (size_t view = 0; view < 6; ++view) {
    EXPECT_EQ(changed(pose, view), 0);
    const Eigen::Vector3d point(0.05, -0.03, 0);
    const double shift = (pose.scene.views[view].camera.Project(point) -
                          clean.scene.views[view].camera.Project(point))
                             .norm();
    EXPECT_NEAR(shift, view == 3 ? 3 : 0, 0.1);
  }
}

}  // namespace
}  // namespace burin
