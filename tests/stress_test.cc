// Faulty photographs: the refined mesh is not worse than the input.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>

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
  // What the photographs do not support is cut away; the whole mesh has it.
  const Evaluation whole = EvaluateMesh(
      result.trimming.has_value() ? result.trimming->whole : result.mesh, seen, options);
  EXPECT_LE(after.accuracy.mean, before.accuracy.mean);
  EXPECT_LE(after.completeness.mean, before.completeness.mean);
  EXPECT_GE(whole.completeness.MatchedShare(), before.completeness.MatchedShare() - 0.02);
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

// Cameras as structure from motion leaves them.
TEST(PoseNoise, HasTheStatisticsAskedFor) {
  Camera truth;
  truth.width = 320;
  truth.height = 240;
  truth.fx = truth.fy = 400;
  truth.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d center(2, -1, 2);  // 3 from the origin
  truth.translation = -truth.rotation * center;
  const double px = 0.8;
  const double angle = px / truth.fx;
  const CounterRandom random(5, 50);
  constexpr int kViews = 4000;
  Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Zero();
  for (int view = 0; view < kViews; ++view) {
    const Camera camera = WithPoseNoise(truth, px, random, view);
    const Eigen::AngleAxisd turn(camera.rotation * truth.rotation.transpose());
    Eigen::Matrix<double, 6, 1> error;
    error << turn.angle() * turn.axis(), camera.Center() - center;
    for (int k = 0; k < 6; ++k) error[k] /= k < 2 ? angle : k == 2 ? 2 * angle : 1.5 * angle;
    mean += error / kViews;
    square += error * error.transpose() / kViews;
  }
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.08);  // five standard errors
  EXPECT_LT((square - Eigen::Matrix<double, 6, 6>::Identity()).cwiseAbs().maxCoeff(), 0.12);
}

TEST(PoseNoise, MovesTheCamerasAndNothingElse) {
  SyntheticOptions options = Small(SyntheticKind::kOccluders, StressKind::kNone);
  const SyntheticScene exact = MakeSyntheticScene(options);
  options.pose_noise_px = 1;
  const SyntheticScene noisy = MakeSyntheticScene(options);
  const SyntheticScene again = MakeSyntheticScene(options);
  options.pose_noise_px = 2;
  const SyntheticScene twice = MakeSyntheticScene(options);
  for (size_t v = 0; v < exact.scene.views.size(); ++v) {
    const View& a = exact.scene.views[v];
    const View& b = noisy.scene.views[v];
    EXPECT_EQ(std::memcmp(a.gray.data, b.gray.data, a.gray.total()), 0);
    EXPECT_EQ(std::memcmp(exact.depth[v].data, noisy.depth[v].data, 4 * exact.depth[v].total()), 0);
    EXPECT_NE(a.camera.rotation, b.camera.rotation);
    EXPECT_EQ(b.camera.rotation, again.scene.views[v].camera.rotation);
    EXPECT_EQ(b.camera.translation, again.scene.views[v].camera.translation);
    EXPECT_EQ(a.camera.fx, b.camera.fx);
    // The same numbers, scaled.
    const Eigen::Vector3d shift = b.camera.Center() - a.camera.Center();
    const Eigen::Vector3d shift_twice = twice.scene.views[v].camera.Center() - a.camera.Center();
    EXPECT_LT((shift_twice - 2 * shift).norm(), 1e-9);
  }
  EXPECT_EQ(exact.truth.vertices, noisy.truth.vertices);
  EXPECT_EQ(exact.init.vertices, noisy.init.vertices);
  EXPECT_EQ(exact.truth_points, noisy.truth_points);
  ASSERT_EQ(exact.scene.points.size(), noisy.scene.points.size());
  for (size_t p = 0; p < exact.scene.points.size(); ++p) {
    EXPECT_EQ(exact.scene.points[p].position, noisy.scene.points[p].position);
  }
}

TEST(IntrinsicsNoise, HasTheStatisticsAskedFor) {
  Camera truth;
  truth.width = 320;
  truth.height = 240;
  truth.fx = 400;
  truth.fy = 402;
  truth.cx = 161;
  truth.cy = 118;
  const CounterRandom random(5, 51);
  constexpr int kCameras = 4000;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (int k = 0; k < kCameras; ++k) {
    const Camera camera = WithIntrinsicsNoise(truth, 0.02, 3, random, k);
    EXPECT_NEAR(camera.fy / camera.fx, truth.fy / truth.fx, 1e-12);
    const Eigen::Vector3d error(std::log(camera.fx / truth.fx) / 0.02, (camera.cx - truth.cx) / 3,
                                (camera.cy - truth.cy) / 3);
    mean += error / kCameras;
    square += error * error.transpose() / kCameras;
  }
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.08);  // five standard errors
  EXPECT_LT((square - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.12);
}

TEST(IntrinsicsNoise, IsOfEachViewOrOfOneCamera) {
  SyntheticOptions options = Small(SyntheticKind::kOccluders, StressKind::kNone);
  const SyntheticScene exact = MakeSyntheticScene(options);
  options.focal_noise = 0.01;
  options.principal_point_noise_px = 2;
  const SyntheticScene noisy = MakeSyntheticScene(options);
  options.one_camera = true;
  const SyntheticScene shared = MakeSyntheticScene(options);
  for (size_t v = 0; v < exact.scene.views.size(); ++v) {
    const Camera& truth = exact.scene.views[v].camera;
    const Camera& a = noisy.scene.views[v].camera;
    const Camera& b = shared.scene.views[v].camera;
    EXPECT_NE(a.fx, truth.fx);
    EXPECT_NE(a.cx, truth.cx);
    EXPECT_EQ(a.rotation, truth.rotation);
    EXPECT_EQ(a.translation, truth.translation);
    EXPECT_EQ(b.fx, noisy.scene.views[0].camera.fx);
    EXPECT_EQ(b.cy, noisy.scene.views[0].camera.cy);
    if (v > 0) {
      EXPECT_NE(a.fx, noisy.scene.views[0].camera.fx);
    }
    EXPECT_EQ(noisy.scene.views[v].origin.camera_id, kNoId);
    EXPECT_EQ(shared.scene.views[v].origin.camera_id, 1U);
    // What took the photographs is known.
    EXPECT_EQ(noisy.true_cameras[v].fx, truth.fx);
    EXPECT_EQ(noisy.true_cameras[v].translation, truth.translation);
    EXPECT_EQ(std::memcmp(exact.scene.views[v].gray.data, noisy.scene.views[v].gray.data,
                          exact.scene.views[v].gray.total()),
              0);
  }
}

TEST(TrackNoise, MovesWhatIsMeasuredAndNothingElse) {
  SyntheticOptions options = Small(SyntheticKind::kRelief, StressKind::kNone);
  const Scene exact = MakeSyntheticScene(options).scene;
  options.track_noise_px = 0.4;
  const Scene noisy = MakeSyntheticScene(options).scene;
  ASSERT_EQ(noisy.points.size(), exact.points.size());
  double squares = 0;
  double count = 0;
  for (size_t p = 0; p < exact.points.size(); ++p) {
    EXPECT_EQ(noisy.points[p].position, exact.points[p].position);
    auto measured = noisy.tracks.Of(p).begin();
    for (const Measurement& truth : exact.tracks.Of(p)) {
      squares += (measured->image_point - truth.image_point).squaredNorm();
      EXPECT_EQ(measured->view, truth.view);
      ++measured;
      count += 2;
    }
  }
  EXPECT_GT(count, 1000);
  EXPECT_NEAR(std::sqrt(squares / count), 0.4, 0.04);
}

}  // namespace
}  // namespace burin
