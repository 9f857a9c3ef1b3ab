// Lenses refined with the cameras: scenes of distorted photographs in files, whole runs.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/cameras_output.h"
#include "apps/run/pipeline.h"
#include "core/cameras/lens_change.h"
#include "core/cameras/track_step.h"
#include "core/image/gray_image.h"
#include "core/scene/camera_similarity.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/lens_points.h"
#include "core/scene/tracks.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/seen_points.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr double kTrueK1 = -0.08;  // moves the corner by 6 px
constexpr double kGivenK1 = -0.04;

const SyntheticScene& Exact() {
  static const auto* scene = [] {
    SyntheticOptions options;
    options.width = 480;
    options.height = 360;
    options.views = 9;
    options.init_edge_px = 25;
    options.seed = 3;
    options.relief_px = 8;
    return new SyntheticScene(MakeSyntheticScene(options));
  }();
  return *scene;
}

// In the images that `lenses` undistort, of what the true lens photographed.
double Error(const std::vector<Camera>& cameras, const std::vector<Lens>& lenses) {
  Scene truth = Exact().scene;
  for (View& view : truth.views) view.origin.lens.brown[0] = kTrueK1;
  const auto sightings =
      SightingsThrough(truth, SeenPoints(Exact().truth, Exact().scene.views), cameras, lenses);
  CameraSimilarity fit;
  std::string error;
  EXPECT_TRUE(FitCameraSimilarity(CamerasOf(truth), cameras, sightings, &fit, &error)) << error;
  return fit.errors.rms_px;
}

// What the lens photographs of a picture without distortion.
cv::Mat Photograph(const cv::Mat& gray, const Camera& camera, const Lens& lens) {
  const PointUndistortion undistort(camera, lens);
  cv::Mat1f x(gray.size());
  cv::Mat1f y(gray.size());
  for (int row = 0; row < gray.rows; ++row) {
    for (int column = 0; column < gray.cols; ++column) {
      const Eigen::Vector2d at =
          undistort({column + 0.5, row + 0.5}).value_or(Eigen::Vector2d(-9, -9));
      x(row, column) = static_cast<float>(at.x() - 0.5);
      y(row, column) = static_cast<float>(at.y() - 0.5);
    }
  }
  cv::Mat photograph;
  cv::remap(gray, photograph, x, y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return photograph;
}

// Where photographs through lens `to` show what those through the true one do, without distortion.
Tracks MeasuredThrough(const Scene& scene, double to) {
  std::vector<LensChange> changes;
  for (View view : scene.views) {
    view.origin.lens.brown[0] = kTrueK1;
    changes.emplace_back(view, view.camera, Lens{{to, 0, 0, 0, 0}, 0});
  }
  Tracks tracks;
  for (size_t p = 0; p < scene.tracks.PointCount(); ++p) {
    tracks.BeginPoint();
    for (const Measurement& measured : scene.tracks.Of(p)) {
      const std::optional<Eigen::Vector2d> at = changes[measured.view](measured.image_point);
      if (at.has_value()) tracks.Add({*at, measured.view, measured.keypoint});
    }
  }
  return tracks;
}

// The relief through a lens, as files; `given_k1` is what the model says of it. The first view has a mask.
void WriteDistorted(const fs::path& folder, double given_k1) {
  Scene scene = Exact().scene;
  for (View& view : scene.views) {
    const Lens lens{{kTrueK1, 0, 0, 0, 0}, 0};
    view.gray = Photograph(view.gray, view.camera, lens);
    view.origin.camera_id = 5;
  }
  scene.tracks = MeasuredThrough(scene, given_k1);
  WriteColmapScene(scene, folder, /*binary=*/false);
  for (View& view : scene.views) {
    view.origin.camera_model = "SIMPLE_RADIAL";
    view.origin.lens.brown[0] = given_k1;
  }
  ASSERT_TRUE(WritePhotographedModel(scene, folder));
  fs::create_directories(folder / "masks");
  cv::Mat1b mask(scene.views[0].gray.size(), uint8_t{255});
  mask(cv::Rect(0, 0, 60, 40)) = 0;
  WriteGrayImage(mask, folder / "masks" / (scene.views[0].name + ".png"));
}

Scene Load(const fs::path& folder) {
  SceneSource source;
  source.path = folder;
  source.masks = folder / "masks";
  return LoadScene(source);
}

std::vector<CameraPair> Pairs(const Scene& scene) {
  return SelectPairs(scene, Exact().init, PairsOptions()).pairs;
}

double LargestDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

TEST(LensCameras, AWrongLensIsMendedAndThePhotographsUndistortedAgain) {
  const TempFolder folder;
  WriteDistorted(folder.path(), kGivenK1);
  const Scene scene = Load(folder.path());
  const TrackStep step = RefineByTracks(scene, Exact().init, Pairs(scene), TrackRule::kNotWorse,
                                        IntrinsicUnknowns::kLens);
  ASSERT_TRUE(step.Kept()) << step.Reason();
  const TrackStep poses = RefineByTracks(scene, Exact().init, Pairs(scene), TrackRule::kNotWorse);
  EXPECT_EQ(poses.seen, nullptr);
  ASSERT_NE(step.seen, nullptr);
  const double k1 = step.bundle.lenses[0].brown[0];
  std::vector<Lens> given;
  for (const View& view : scene.views) given.push_back(view.origin.lens);
  const double by_poses = Error(poses.cameras, given);
  const double by_all = Error(step.cameras, step.bundle.lenses);
  std::printf("k1 %.4f -> %.4f (%.4f); %.3f px -> poses %.3f, intrinsics %.3f\n", kGivenK1, k1,
              kTrueK1, Error(CamerasOf(scene), given), by_poses, by_all);
  EXPECT_NEAR(k1, kTrueK1, 0.004);
  EXPECT_LT(by_all, 0.12);
  EXPECT_LT(by_all, 0.25 * by_poses);
  // The pictures without distortion are those that were distorted, but for what resampling takes.
  const cv::Rect inside(20, 20, 440, 320);
  const View& seen = step.seen->views[4];
  const cv::Mat was = Exact().scene.views[4].gray(inside);
  EXPECT_LT(cv::norm(seen.gray(inside), was, cv::NORM_L1),
            0.7 * cv::norm(scene.views[4].gray(inside), was, cv::NORM_L1));
  EXPECT_EQ(seen.origin.lens.brown[0], k1);
  EXPECT_TRUE(seen.camera.HasIntrinsicsOf(step.cameras[4]));
  EXPECT_EQ(seen.camera.rotation, scene.views[4].camera.rotation);
  // Masks too.
  EXPECT_GT(LargestDifference(step.seen->views[0].mask, scene.views[0].mask), 0);
  EXPECT_EQ(step.seen->views[0].mask.at<uint8_t>(10, 10), 0);
}

TEST(LensCameras, WhatIsWrittenIsReadAsWhatWasRefined) {
  const TempFolder folder;
  WriteDistorted(folder.path(), kGivenK1);
  const Scene scene = Load(folder.path());
  const TrackStep step = RefineByTracks(scene, Exact().init, Pairs(scene), TrackRule::kNotWorse,
                                        IntrinsicUnknowns::kLens);
  ASSERT_TRUE(step.Kept()) << step.Reason();
  const fs::path out = folder.path() / "out";
  EXPECT_EQ(WriteCameras(*step.seen, step.cameras, out), "");
  SceneSource source;
  source.path = out;
  source.images = folder.path() / "images";
  source.masks = folder.path() / "masks";
  const Scene read = LoadScene(source);
  ASSERT_EQ(read.views.size(), scene.views.size());
  for (size_t v = 0; v < read.views.size(); ++v) {
    const View& view = read.views[v];
    EXPECT_EQ(view.origin.camera_model, "SIMPLE_RADIAL");
    EXPECT_EQ(view.origin.camera_id, 5U);
    EXPECT_EQ(view.origin.lens.brown, step.bundle.lenses[v].brown);
    EXPECT_NEAR(view.camera.fx, step.cameras[v].fx, 1e-8);
    EXPECT_NEAR(view.camera.cy, step.cameras[v].cy, 1e-8);
    EXPECT_LT((view.camera.translation - step.cameras[v].translation).norm(), 1e-10);
    EXPECT_LE(LargestDifference(view.gray, step.seen->views[v].gray), 1);
  }
  // The photographs' measurements are as they were read, whatever the lens.
  source.path = folder.path();
  const PosedScene before = ReadScene(source);
  source.path = out;
  const PosedScene after = ReadScene(source);
  ASSERT_EQ(before.tracks.Count(), after.tracks.Count());
  ASSERT_GT(before.tracks.Count(), 100U);
  for (size_t p = 0; p < before.points.size(); ++p) {
    ASSERT_EQ(before.tracks.Of(p).size(), after.tracks.Of(p).size());
    for (size_t k = 0; k < before.tracks.Of(p).size(); ++k) {
      EXPECT_LT((before.tracks.Of(p).first[k].image_point - after.tracks.Of(p).first[k].image_point)
                    .norm(),
                1e-5);
    }
  }
}

TEST(LensCameras, ARunThatGoesOnComesToTheSameBytesOnAnyNumberOfThreads) {
  const TempFolder folder;
  WriteDistorted(folder.path(), kGivenK1);
  const Scene scene = Load(folder.path());
  PipelineOptions options;
  options.refinement.cameras.refine = CameraUnknowns::kPosesIntrinsics;
  options.refinement.cameras.coarsest_joint = options.refinement.cameras.finest_joint = 0;
  options.refinement.level.count = 1;
  options.refinement.level.rounds = 3;
  options.refinement.solver.max_iterations = 4;
  options.threads = 1;
  options.surface.trim = SurfaceTrim::kNone;  // the others measure no quality
  std::vector<std::vector<uint8_t>> states;
  PipelineParts parts;
  parts.observers.on_state = [&](const RefinementState& state) {
    states.push_back(StateBytes(state));
  };
  parts.measure_quality = true;
  const PipelineResult whole = RunPipeline(scene, Exact().init, options, parts);
  // The input as it was seen, the result in the new pixels.
  ASSERT_TRUE(whole.closing.has_value());
  ASSERT_TRUE(whole.closing->held_back.has_value());
  ASSERT_TRUE(whole.by_tracks.has_value());
  ASSERT_TRUE(whole.by_tracks->Kept()) << whole.by_tracks->Reason();
  EXPECT_NE(whole.refinement.cameras[0].rotation, whole.refinement.first_cameras[0].rotation);
  EXPECT_TRUE(whole.refinement.cameras[0].HasIntrinsicsOf(whole.refinement.first_cameras[0]));
  ASSERT_GE(states.size(), 2U);
  options.threads = 2;
  for (const size_t k : {size_t{0}, states.size() - 1}) {
    const RefinementState start = StateFromBytes(states[k]);
    PipelineParts rest;
    rest.start = &start;
    rest.tracks_hold_all = whole.by_tracks->HoldsAllViews();
    rest.measure_quality = false;
    const PipelineResult result = RunPipeline(scene, Exact().init, options, rest);
    EXPECT_EQ(result.mesh.vertices, whole.mesh.vertices) << k;
    ASSERT_NE(result.seen, nullptr);
    EXPECT_EQ(LargestDifference(result.seen->views[3].gray, whole.seen->views[3].gray), 0);
    for (size_t v = 0; v < scene.views.size(); ++v) {
      const Camera& camera = result.refinement.cameras[v];
      EXPECT_TRUE(camera.HasIntrinsicsOf(whole.refinement.cameras[v]));
      EXPECT_EQ(camera.translation, whole.refinement.cameras[v].translation);
    }
  }
}

}  // namespace
}  // namespace burin
