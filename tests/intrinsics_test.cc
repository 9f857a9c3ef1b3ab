// Intrinsics refined with poses over tracks through the mesh (core/cameras/intrinsics.h).
#include "core/cameras/intrinsics.h"

#include <ceres/ceres.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "apps/run/cameras_output.h"
#include "apps/run/intrinsics_output.h"
#include "apps/run/pipeline.h"
#include "core/cameras/lens_change.h"
#include "core/cameras/lens_reprojection.h"
#include "core/cameras/track_step.h"
#include "core/image/gray_image.h"
#include "core/scene/camera_similarity.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/lens_points.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/seen_points.h"
#include "tests/colmap_testing.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

using testing::HasSubstr;

// ---- the residual

struct LensCase {
  const char* model;
  Lens lens;
};

const LensCase kLenses[] = {
    {"SIMPLE_PINHOLE", {}},
    {"PINHOLE", {}},
    {"SIMPLE_RADIAL", {{-0.2, 0, 0, 0, 0}, 0}},
    {"RADIAL", {{-0.25, 0.1, 0, 0, 0}, 0}},
    {"OPENCV", {{-0.2, 0.05, 0.01, -0.02, 0}, 0}},
    {"pinhole", {}},
    {"pinhole_radial_k1", {{0.15, 0, 0, 0, 0}, 0}},
    {"pinhole_radial_k3", {{-0.2, 0.1, 0, 0, -0.03}, 0}},
    {"pinhole_brown_t2", {{-0.2, 0.1, 0.01, 0.015, -0.03}, 0}},
    {"", {{0, 0, 0, 0, 0}, 0.2}},  // VisualSFM
    {"", {{0, 0, 0, 0, 0}, -0.15}},
    {"", {{-0.1, 0.04, 0, 0, 0}, 0}},  // Bundler
};

View SomeView(const LensCase& lens) {
  View view;
  view.name = "a.png";
  view.image_path = "a.png";
  view.camera = test::LookAt({0.4, 0.3, 3}, {0.1, 0, 0}, 640, 480, 600);
  view.camera.fy = 590;
  view.camera.cx += 4;
  view.origin.camera_model = lens.model;
  view.origin.lens = lens.lens;
  return view;
}

TEST(Intrinsics, DerivativesOfEveryCameraModelAreThoseOfCentralDifferences) {
  for (const LensCase& lens : kLenses) {
    SCOPED_TRACE(std::string(lens.model) + " " + std::to_string(lens.lens.measured));
    Scene scene;
    scene.views.push_back(SomeView(lens));
    std::vector<SharedIntrinsics> shared = CamerasSharedIn(scene, IntrinsicUnknowns::kLens);
    ASSERT_EQ(shared.size(), 1U);
    test::Random random(11);
    for (int trial = 0; trial < 5; ++trial) {
      CameraPose pose = PoseOf(scene.views[0].camera);
      IntrinsicNumbers q = {};
      for (double& number : q) number = 5 * random.Uniform();
      if (lens.lens.measured == 0) q[kMeasured] = 0;
      Eigen::Vector3d point = random.Vector();
      const ceres::AutoDiffCostFunction<LensReprojection, 2, 7, kIntrinsics, 3> differentiated(
          new LensReprojection{shared[0], {300, 200}, 1.7});
      double* blocks[] = {pose.data(), q.data(), point.data()};
      const int sizes[] = {7, kIntrinsics, 3};
      double by_pose[14];
      double by_q[2 * kIntrinsics];
      double by_point[6];
      double* jacobians[] = {by_pose, by_q, by_point};
      Eigen::Vector2d residual;
      ASSERT_TRUE(differentiated.Evaluate(blocks, residual.data(), jacobians));
      // The photograph, by the library's other formula.
      const Camera camera = [&] {
        Camera at = shared[0].CameraAt(q);
        at.rotation = scene.views[0].camera.rotation;
        at.translation = scene.views[0].camera.translation;
        return at;
      }();
      const Eigen::Vector2d shown =
          PhotographedAt(camera, shared[0].LensAt(q), camera.Project(point));
      EXPECT_LT((1.7 * residual - (shown - Eigen::Vector2d(300, 200))).norm(), 1e-9);
      for (int block = 0; block < 3; ++block) {
        for (int k = 0; k < sizes[block]; ++k) {
          const double step = 1e-6 * (block == 1 ? 100 : 1);
          double& number = blocks[block][k];
          const double at = number;
          Eigen::Vector2d after;
          Eigen::Vector2d before;
          number = at + step;
          ASSERT_TRUE(differentiated.Evaluate(blocks, after.data(), nullptr));
          number = at - step;
          ASSERT_TRUE(differentiated.Evaluate(blocks, before.data(), nullptr));
          number = at;
          const Eigen::Vector2d difference = (after - before) / (2 * step);
          const Eigen::Vector2d derivative(jacobians[block][k], jacobians[block][sizes[block] + k]);
          EXPECT_LT((difference - derivative).norm(), 1e-6 * (1 + derivative.norm()))
              << "block " << block << " number " << k;
        }
      }
    }
  }
}

TEST(Intrinsics, FreeIsWhatTheModelHasAndAFileCanBeUndistortedBy) {
  const auto free = [](const LensCase& lens, IntrinsicUnknowns unknowns, bool file) {
    Scene scene;
    scene.views.push_back(SomeView(lens));
    if (!file) scene.views[0].image_path.clear();
    std::string text;
    const SharedIntrinsics shared = CamerasSharedIn(scene, unknowns)[0];
    for (const bool one : shared.free) text += one ? '1' : '0';
    return text;
  };
  const auto lens = IntrinsicUnknowns::kLens;
  EXPECT_EQ(free({"PINHOLE", {}}, lens, true), "1111000000");
  EXPECT_EQ(free({"SIMPLE_RADIAL", {}}, lens, true), "1111100000");
  EXPECT_EQ(free({"SIMPLE_RADIAL", {}}, lens, false), "1111000000");
  EXPECT_EQ(free({"RADIAL", {{-0.1, 0, 0, 0, 0}, 0}}, lens, true), "1111110000");
  EXPECT_EQ(free({"RADIAL", {{-0.1, 0, 0, 0, 0}, 0}}, lens, false), "0000000000");
  EXPECT_EQ(free({"OPENCV", {}}, lens, true), "1111111100");
  EXPECT_EQ(free({"OPENCV", {}}, IntrinsicUnknowns::kFocal, true), "1000000000");
  EXPECT_EQ(free({"pinhole_radial_k3", {{-0.1, 0, 0, 0, 0.1}, 0}}, lens, true), "1111110010");
  EXPECT_EQ(free({"pinhole_radial_k3", {{-0.1, 0, 0, 0, 0}, 0}}, lens, true), "1111110000");
  EXPECT_EQ(free({"", {{0, 0, 0, 0, 0}, 0.1}}, lens, true), "1111000001");
  EXPECT_EQ(free({"", {{-0.1, 0.02, 0, 0, 0}, 0}}, lens, true), "1111110000");
}

TEST(Intrinsics, AreSharedByNumberOrWhereNoneIsGivenByValue) {
  Scene scene;
  for (int v = 0; v < 6; ++v) scene.views.push_back(SomeView(kLenses[1]));
  scene.views[1].camera.fx *= 1.05;
  scene.views[2].origin.camera_id = scene.views[4].origin.camera_id = 3;
  scene.views[5].origin.camera_id = 4;
  std::vector<std::vector<int>> views;
  for (const SharedIntrinsics& shared : CamerasSharedIn(scene, IntrinsicUnknowns::kFocal)) {
    views.push_back(shared.views);
  }
  EXPECT_EQ(views, (std::vector<std::vector<int>>{{0, 3}, {1}, {2, 4}, {5}}));
  EXPECT_TRUE(CamerasSharedIn(scene, IntrinsicUnknowns::kNone).empty());
}

// ---- scenes in memory

SyntheticOptions ReliefOptions() {
  SyntheticOptions options;
  options.width = 480;
  options.height = 360;
  options.views = 9;
  options.init_edge_px = 25;
  options.seed = 3;
  options.relief_px = 8;
  return options;
}

const SyntheticScene& Exact() {
  static const auto* scene = new SyntheticScene(MakeSyntheticScene(ReliefOptions()));
  return *scene;
}

double Error(const std::vector<Camera>& cameras) {
  CameraSimilarity fit;
  std::string error;
  EXPECT_TRUE(FitCameraSimilarity(CamerasOf(Exact().scene), cameras,
                                  SeenPoints(Exact().truth, Exact().scene.views), &fit, &error))
      << error;
  return fit.errors.rms_px;
}

std::vector<CameraPair> Pairs() {
  static const auto* pairs =
      new std::vector<CameraPair>(SelectPairs(Exact().scene, Exact().init, PairsOptions()).pairs);
  return *pairs;
}

TrackStep Step(const Scene& scene, IntrinsicUnknowns unknowns) {
  return RefineByTracks(scene, Exact().init, Pairs(), TrackRule::kNotWorse, unknowns);
}

TEST(Intrinsics, AFocalLengthThatIsFivePerCentOffIsMendedAndNamed) {
  Scene scene = Exact().scene;
  scene.views[4].camera.fx *= 1.05;
  scene.views[4].camera.fy *= 1.05;
  for (size_t v = 0; v < scene.views.size(); ++v) scene.views[v].origin.camera_id = v;
  const double before = Error(CamerasOf(scene));
  const TrackStep step = Step(scene, IntrinsicUnknowns::kFocal);
  ASSERT_TRUE(step.Kept()) << step.Reason();
  const double after = Error(step.cameras);
  std::printf("one focal length 5 %% off: %.3f -> %.3f px\n", before, after);
  EXPECT_LT(after, 0.15);
  const double truth = Exact().scene.views[4].camera.fx;
  EXPECT_NEAR(step.cameras[4].fx / truth, 1, 0.002);
  EXPECT_NEAR(step.cameras[3].fx / truth, 1, 0.002);
  EXPECT_EQ(step.cameras[4].cx, scene.views[4].camera.cx);
  std::string text;
  for (const std::string& line : TrackStepText(step, scene)) text += line + "\n";
  EXPECT_THAT(text, HasSubstr(scene.views[4].name + ": focal length "));
  EXPECT_THAT(text, HasSubstr("far more than the others"));
  const nlohmann::ordered_json json = IntrinsicsJson(step, scene);
  ASSERT_EQ(json.size(), 9U);
  EXPECT_EQ(json[4]["far_off"], true);
  EXPECT_EQ(json[3]["far_off"], false);
  EXPECT_NEAR(json[4]["focal_length"]["edge_px"].get<double>(), -0.05 / 1.05 * 240, 0.6);
}

// All focal lengths 1 % off, or the principal point 3 px: one camera, or one a view, whose principal points hardly differ from turns.
TEST(Intrinsics, WhatAllPhotographsHaveWrongIsMended) {
  for (const bool shared : {true, false}) {
    for (const bool focal : {true, false}) {
      SCOPED_TRACE(std::string(shared ? "one camera" : "each its own") +
                   (focal ? ", focal length" : ", principal point"));
      Scene scene = Exact().scene;
      for (size_t v = 0; v < scene.views.size(); ++v) {
        View& view = scene.views[v];
        view.origin.camera_id = shared ? 1 : v;
        if (focal) {
          view.camera.fx *= 1.01;
          view.camera.fy *= 1.01;
        } else {
          view.camera.cx += 3;
          view.camera.cy -= 3;
        }
      }
      const double before = Error(CamerasOf(scene));
      const TrackStep poses = Step(scene, IntrinsicUnknowns::kNone);
      const TrackStep step =
          Step(scene, focal ? IntrinsicUnknowns::kFocal : IntrinsicUnknowns::kLens);
      ASSERT_TRUE(step.Kept()) << step.Reason();
      const Camera& truth = Exact().scene.views[2].camera;
      const Camera& now = step.cameras[2];
      std::printf(
          "%s %s off: %.3f -> %.3f px (poses alone %.3f); focal %.5f, principal point %.2f %.2f\n",
          shared ? "one camera's" : "every view's", focal ? "focal length" : "principal point",
          before, Error(step.cameras), Error(poses.cameras), now.fx / truth.fx, now.cx - truth.cx,
          now.cy - truth.cy);
      if (!focal && !shared) {
        EXPECT_LT(Error(step.cameras), 1.05 * Error(poses.cameras));
        continue;
      }
      EXPECT_LT(Error(step.cameras), 0.06);
      EXPECT_LT(Error(step.cameras), 0.3 * Error(poses.cameras));
      if (!shared) continue;
      const SharedIntrinsics& one = step.bundle.shared[0];
      EXPECT_EQ(one.views.size(), 9U);
      const double off_px =
          focal ? (now.fx / truth.fx - 1) * 240 : std::hypot(now.cx - truth.cx, now.cy - truth.cy);
      EXPECT_LT(std::abs(off_px), focal ? 0.2 : 1.5);
      EXPECT_GT(one.deviation_px[kFocal], 0);
      EXPECT_LT(one.deviation_px[kFocal], 1);
      for (const Camera& camera : step.cameras) EXPECT_TRUE(camera.HasIntrinsicsOf(now));
    }
  }
}

TEST(Intrinsics, ACameraWithFewMeasurementsKeepsItsOwn) {
  Scene scene = Exact().scene;
  for (size_t v = 0; v < scene.views.size(); ++v) scene.views[v].origin.camera_id = v;
  MeshTracks tracks;
  tracks.pixel.assign(scene.views.size(), 1);
  const auto surface = SeenPoints(Exact().truth, scene.views, 200);
  for (size_t p = 0; p < surface[4].size(); ++p) {
    const Eigen::Vector3d& point = surface[4][p];
    tracks.points.push_back(point);
    tracks.tracks.BeginPoint();
    for (size_t v = 0; v < scene.views.size(); ++v) {
      if (v == 0 && p >= kFewestForIntrinsics) continue;
      tracks.tracks.Add({scene.views[v].camera.Project(point), static_cast<int>(v)});
    }
  }
  ASSERT_GT(tracks.points.size(), 80U);
  for (View& view : scene.views) view.camera.fx *= 1.01;
  const Bundle bundle = AdjustBundle(scene, tracks, IntrinsicUnknowns::kFocal);
  EXPECT_FALSE(bundle.shared[0].AnyFree());
  EXPECT_EQ(bundle.cameras[0].fx, scene.views[0].camera.fx);
  EXPECT_TRUE(bundle.shared[1].AnyFree());
  EXPECT_NE(bundle.cameras[1].fx, scene.views[1].camera.fx);
}

// Views side by side before a wall: its distance and the focal length are one. The prior keeps it, and it is known no better than
// the prior says.
TEST(Intrinsics, WhatAWallDoesNotTellStaysAndIsUncertain) {
  Scene scene;
  for (int v = 0; v < 5; ++v) {
    View& view = scene.views.emplace_back();
    view.name = std::to_string(v);
    const Eigen::Vector3d center(0.4 * (v - 2), 0.1 * (v % 2), 3);
    view.camera = test::LookAt(center, center - 3 * Eigen::Vector3d::UnitZ(), 640, 480, 600);
    view.origin.camera_id = 1;
  }
  MeshTracks tracks;
  tracks.pixel.assign(scene.views.size(), 1);
  test::Random random(5);
  for (int p = 0; p < 400; ++p) {
    const Eigen::Vector3d point(0.5 * random.Uniform(), 0.5 * random.Uniform(), 0);
    tracks.points.push_back(point);
    tracks.tracks.BeginPoint();
    for (int v = 0; v < 5; ++v) {
      const Eigen::Vector3d noise = 0.3 * random.Vector();
      tracks.tracks.Add({scene.views[v].camera.Project(point) + noise.head<2>(), v});
    }
  }
  const std::vector<Camera> truth = CamerasOf(scene);
  for (View& view : scene.views) {
    view.camera.fx *= 1.01;
    view.camera.fy *= 1.01;
  }
  const Bundle bundle = AdjustBundle(scene, tracks, IntrinsicUnknowns::kFocal);
  const SharedIntrinsics& shared = bundle.shared[0];
  ASSERT_TRUE(shared.AnyFree());
  std::printf("focal length 606 -> %.2f, standard deviation %.2f px\n", bundle.cameras[0].fx,
              shared.deviation_px[kFocal]);
  EXPECT_LT(std::abs(bundle.cameras[0].fx / 606 - 1) * 320, 2 * shared.deviation_px[kFocal]);
  EXPECT_GT(shared.deviation_px[kFocal], 1);
  EXPECT_LT(shared.deviation_px[kFocal], kPriorPx);
  CameraSimilarity fit;
  std::string error;
  ASSERT_TRUE(FitCameraSimilarity(truth, bundle.cameras,
                                  std::vector<std::vector<Eigen::Vector3d>>(5, tracks.points), &fit,
                                  &error));
  EXPECT_LT(fit.errors.rms_px, 0.1);
}

// The errors of many adjustments are as large as said. Those of what is weakly known, a principal point that a turn nearly makes up for, are
// smaller: the adjustment weighs measurements as if they had a deviation of 1 px, so that the prior holds it nearer to the start, here the truth.
TEST(Intrinsics, DeviationsAreThoseOfRepeatedMeasurements) {
  Scene scene = Exact().scene;
  for (View& view : scene.views) view.origin.camera_id = 1;
  const auto surface = SeenPoints(Exact().truth, scene.views, 200);
  constexpr double kSigma = 0.1;
  constexpr int kTrials = 40;
  test::Random random(9);
  IntrinsicNumbers squares = {};
  IntrinsicNumbers said = {};
  for (int trial = 0; trial < kTrials; ++trial) {
    MeshTracks tracks;
    tracks.pixel.assign(scene.views.size(), 1);
    for (const Eigen::Vector3d& point : surface[4]) {
      tracks.points.push_back(point);
      tracks.tracks.BeginPoint();
      for (size_t v = 0; v < scene.views.size(); ++v) {
        // Uniform numbers, six of them: nearly normal with a deviation of sqrt(2).
        Eigen::Vector2d noise = Eigen::Vector2d::Zero();
        for (int k = 0; k < 6; ++k) noise += random.Vector().head<2>();
        tracks.tracks.Add({scene.views[v].camera.Project(point) + kSigma / std::sqrt(2.0) * noise,
                           static_cast<int>(v)});
      }
    }
    const Bundle bundle = AdjustBundle(scene, tracks, IntrinsicUnknowns::kLens);
    const SharedIntrinsics& shared = bundle.shared[0];
    const Camera& was = scene.views[0].camera;
    const Camera& now = bundle.cameras[0];
    const double off[] = {(now.fx / was.fx - 1) / shared.unit[kFocal], now.cx - was.cx,
                          now.cy - was.cy};
    const int number[] = {kFocal, kCenter, kCenter + 1};
    for (int k = 0; k < 3; ++k) {
      squares[number[k]] += off[k] * off[k] / kTrials;
      said[number[k]] += std::pow(shared.deviation_px[number[k]], 2) / kTrials;
    }
  }
  for (const int k : {kFocal, kCenter, kCenter + 1}) {
    std::printf("number %d: measured %.4f px, said %.4f px\n", k, std::sqrt(squares[k]),
                std::sqrt(said[k]));
    EXPECT_LT(std::sqrt(squares[k] / said[k]), 1.2) << k;
    EXPECT_GT(std::sqrt(squares[k] / said[k]), k == kFocal ? 0.7 : 0.4) << k;
  }
}

TEST(Intrinsics, StepsWithoutTracksRefineNone) {
  PipelineOptions options;
  options.refinement.cameras.refine = CameraUnknowns::kPosesFocal;
  options.refinement.cameras.steps = CameraSteps::kJoint;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace burin
