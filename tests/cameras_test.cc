// Cameras refined by tracks through the mesh (core/cameras).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "apps/run/cameras_output.h"
#include "apps/run/intrinsics_output.h"
#include "apps/run/pipeline.h"
#include "core/cameras/pose_uncertainty.h"
#include "core/cameras/track_step.h"
#include "core/evidence/window_places.h"
#include "core/scene/camera_similarity.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/lens_points.h"
#include "core/support/counter_random.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/seen_points.h"
#include "tests/measured_scene.h"

namespace burin {
namespace {

SyntheticScene Relief(double noise_px) {
  SyntheticOptions options;
  options.width = 480;
  options.height = 360;
  options.views = 9;
  options.init_edge_px = 25;
  options.pose_noise_px = noise_px;
  options.seed = 3;
  return MakeSyntheticScene(options);
}

// With the exact cameras, the same photographs.
const SyntheticScene& Exact() {
  static const auto* scene = new SyntheticScene(Relief(0));
  return *scene;
}

const SyntheticScene& Noisy() {
  static const auto* scene = new SyntheticScene(Relief(1));
  return *scene;
}

double Error(const std::vector<Camera>& cameras, Similarity* motion = nullptr) {
  CameraSimilarity fit;
  std::string error;
  EXPECT_TRUE(FitCameraSimilarity(CamerasOf(Exact().scene), cameras,
                                  SeenPoints(Exact().truth, Exact().scene.views), &fit, &error))
      << error;
  if (motion != nullptr) *motion = fit.second_from_first;
  return fit.errors.rms_px;
}

TrackStep Step(const SyntheticScene& scene) {
  return RefineByTracks(scene.scene, scene.init,
                        SelectPairs(scene.scene, scene.init, PairsOptions()).ForTracks(),
                        TrackRule::kBetter);
}

TEST(Cameras, TracksThroughTheMeshTakeTheErrorAway) {
  const double before = Error(CamerasOf(Noisy().scene));
  const TrackStep step = Step(Noisy());
  EXPECT_TRUE(step.Kept()) << step.Reason();
  EXPECT_EQ(TrackStepText(step, Noisy().scene).size(), 1U);
  const double after = Error(step.cameras);
  EXPECT_GT(before, 1);
  EXPECT_LT(after, 0.25 * before);
  RecordProperty("before", std::to_string(before));
  RecordProperty("after", std::to_string(after));
  std::printf("camera error %.3f -> %.3f px, sd %.3f, moved %.3f, %d tracks\n", before, after,
              step.deviation_rms_px, step.moved_rms_px, step.bundle.tracks);
}

TEST(Cameras, ExactOnesAreLeftAsGiven) {
  const TrackStep step = Step(Exact());
  std::printf("would move %.3f px, sd %.3f, kept out %.4f -> %.4f (se %.4f): %s\n",
              step.moved_rms_px, step.deviation_rms_px, step.groups[0].agreement.before,
              step.groups[0].agreement.after, step.groups[0].agreement.standard_error,
              step.Reason().c_str());
  EXPECT_FALSE(step.Kept());
  EXPECT_FALSE(step.Reason().empty());
  EXPECT_EQ(CamerasOf(Exact().scene)[0].rotation, step.cameras[0].rotation);
}

TEST(Cameras, TheFrameIsTheInputs) {
  const std::vector<Camera> given = CamerasOf(Noisy().scene);
  const TrackStep step = Step(Noisy());
  CameraSimilarity fit;
  std::string error;
  ASSERT_TRUE(FitCameraSimilarity(given, step.cameras,
                                  SeenPoints(Noisy().init, Noisy().scene.views), &fit, &error));
  EXPECT_NEAR(fit.second_from_first.scale, 1, 1e-6);
  EXPECT_LT(fit.second_from_first.AngleDeg(), 1e-4);
  EXPECT_LT(fit.second_from_first.translation.norm(), 1e-2 * Noisy().footprint);
}

// One view turned by 1 degree, 8 px and more here.
TEST(Cameras, AViewThatIsFarOffIsNamedAndTheOthersStay) {
  SyntheticScene turned = Exact();
  Camera& camera = turned.scene.views[3].camera;
  const Eigen::Vector3d center = camera.Center();
  camera.rotation =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 1, 0).normalized()).matrix() * camera.rotation;
  camera.translation = -(camera.rotation * center);
  const TrackStep step = Step(turned);
  ASSERT_TRUE(step.Kept()) << step.Reason();
  EXPECT_EQ(step.misregistered, std::vector<int>{3});
  EXPECT_LT(Error(step.cameras), 0.1);
  EXPECT_LT(step.moved_px[0], 0.2);
}

TEST(Cameras, AreTheSameOnAnyNumberOfThreads) {
  std::vector<std::vector<Camera>> cameras;
  for (const int threads : {1, 2}) {
    const ThreadScope scope(threads);
    cameras.push_back(Step(Noisy()).cameras);
  }
  for (size_t v = 0; v < cameras[0].size(); ++v) {
    EXPECT_EQ(cameras[0][v].rotation, cameras[1][v].rotation);
    EXPECT_EQ(cameras[0][v].translation, cameras[1][v].translation);
  }
}

TEST(Cameras, PlacesInReducedPhotographsOfOddSizesAreRight) {
  View view;
  view.camera = Exact().scene.views[0].camera.Resized(481, 363);
  view.gray = cv::Mat1b(363, 481, uint8_t{7});
  const SmallView small = Reduce(view, 250);
  EXPECT_EQ(small.image.size(), cv::Size(240, 181));
  const Eigen::Vector3d point = view.camera.Center() + 2 * view.camera.Ray(400, 350);
  EXPECT_LT((small.InPhotograph(small.camera.Project(point)) - Eigen::Vector2d(400, 350)).norm(),
            1e-9);
}

// A rule for what is known to be better, and one for what is not known to be worse.
TEST(Cameras, PosesAreTakenWhereTheyAreNotWorse) {
  const std::vector<CameraPair> pairs =
      SelectPairs(Exact().scene, Exact().init, PairsOptions()).ForTracks();
  const TrackStep step = RefineByTracks(Exact().scene, Exact().init, pairs, TrackRule::kNotWorse);
  EXPECT_TRUE(step.Kept() || step.groups[0].agreement.Worse()) << step.Reason();
  EXPECT_LT(Error(step.cameras), 0.1);
}

TEST(Cameras, WithoutPairsOrSurfaceTheyStay) {
  const TrackStep none = RefineByTracks(Exact().scene, Exact().init, {}, TrackRule::kNotWorse);
  EXPECT_FALSE(none.Kept());
  EXPECT_FALSE(none.Reason().empty());
  Scene numbered = Exact().scene;
  for (size_t v = 0; v < numbered.views.size(); ++v) numbered.views[v].origin.camera_id = v + 1;
  const TrackStep held =
      RefineByTracks(numbered, Exact().init, {}, TrackRule::kNotWorse, IntrinsicUnknowns::kLens);
  ASSERT_EQ(held.bundle.shared.size(), numbered.views.size());
  EXPECT_TRUE(IntrinsicsText(held, numbered).empty());
  TriangleMesh away = Exact().init;
  for (Eigen::Vector3d& vertex : away.vertices) vertex.z() += 1000;
  const std::vector<CameraPair> pairs = {{0, 1}, {1, 2}, {2, 1}, {1, 0}};
  const TrackStep unseen = RefineByTracks(Exact().scene, away, pairs, TrackRule::kNotWorse);
  EXPECT_FALSE(unseen.Kept());
  EXPECT_EQ(unseen.cameras[1].rotation, Exact().scene.views[1].camera.rotation);
}

// Nothing says how the two groups lie to each other: each has a frame of its own, and both are kept.
TEST(Cameras, GroupsWithoutCommonTracksHaveFramesOfTheirOwn) {
  const std::vector<CameraPair> all =
      SelectPairs(Noisy().scene, Noisy().init, PairsOptions()).ForTracks();
  std::vector<CameraPair> pairs;
  for (const CameraPair& pair : all) {
    const bool first = pair.reference < 4;
    if (pair.reference == 4 || pair.second == 4 || (pair.second < 4) != first) continue;
    pairs.push_back(pair);
  }
  Scene without_tracks = Noisy().scene;
  without_tracks.tracks = Tracks();
  const TrackStep step = RefineByTracks(without_tracks, Noisy().init, pairs, TrackRule::kBetter);
  ASSERT_EQ(step.groups.size(), 2U);
  EXPECT_EQ(step.groups[0].views, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(step.groups[1].views, (std::vector<int>{5, 6, 7, 8}));
  EXPECT_EQ(step.cameras[4].rotation, Noisy().scene.views[4].camera.rotation);
  EXPECT_TRUE(std::isnan(step.moved_px[4]));
  const std::vector<std::string> lines = TrackStepText(step, Noisy().scene);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1],
            "cameras: 2 groups of views (view_000.png, view_001.png, view_002.png and 1 more | "
            "view_005.png, view_006.png, view_007.png and 1 more): no tracks join them, so how "
            "they lie to each other is only as given; the standard deviation is within the groups");
  EXPECT_EQ(lines[2], "view_004.png: left as given, too few windows match through the mesh");
  const auto surface = SeenPoints(Noisy().init, Noisy().scene.views);
  for (const TrackGroup& group : step.groups) {
    EXPECT_TRUE(group.kept) << group.reason;
    EXPECT_LT(group.deviation_rms_px, 0.3);
    std::vector<std::vector<Eigen::Vector3d>> seen(surface.size());
    for (const int v : group.views) seen[v] = surface[v];
    std::string error;
    CameraSimilarity fit;
    ASSERT_TRUE(FitCameraSimilarity(CamerasOf(Noisy().scene), step.cameras, seen, &fit, &error));
    EXPECT_NEAR(fit.second_from_first.scale, 1, 1e-6);
    EXPECT_LT(fit.second_from_first.AngleDeg(), 1e-4);
    ASSERT_TRUE(FitCameraSimilarity(CamerasOf(Exact().scene), step.cameras, seen, &fit, &error));
    EXPECT_LT(fit.errors.rms_px, 0.25);
  }
}

// Five points that views of both groups show are a hinge, not a hold.
TEST(ViewGroups, AFewCommonTracksDoNotJoinGroups) {
  Tracks tracks;
  const auto add = [&](const std::vector<int>& views, int times) {
    for (int k = 0; k < times; ++k) {
      tracks.BeginPoint();
      for (const int v : views) tracks.Add({Eigen::Vector2d(k, v), v});
    }
  };
  add({0, 1, 2}, 20);
  add({5, 4}, 20);
  add({0, 1, 4}, 5);
  add({2, 5}, 5);
  add({3, 0}, 11);
  std::vector<int> kept;
  const ViewGroups groups = GroupViews(7, &tracks, &kept);
  EXPECT_EQ(groups.count, 2);
  EXPECT_EQ(groups.of_view, (std::vector<int>{0, 0, 0, -1, 1, 1, -1}));
  EXPECT_EQ(groups.ViewsOf(1), (std::vector<int>{4, 5}));
  ASSERT_EQ(tracks.PointCount(), 45U);
  EXPECT_EQ(kept[40], 40);
  EXPECT_EQ(tracks.Of(40).size(), 2U);  // view 4 was in another group
  for (const Measurement& measured : tracks.Of(44)) EXPECT_LT(measured.view, 2);
}

TEST(ViewGroups, ElevenCommonTracksAreNone) {
  Tracks tracks;
  for (int k = 0; k < 11; ++k) {
    tracks.BeginPoint();
    for (const int v : {0, 1}) tracks.Add({Eigen::Vector2d(k, v), v});
  }
  std::vector<int> kept;
  const ViewGroups groups = GroupViews(2, &tracks, &kept);
  EXPECT_EQ(groups.count, 0);
  EXPECT_EQ(tracks.PointCount(), 0U);
  EXPECT_TRUE(kept.empty());
}

// Tracks of exact places with normal noise: the errors of many adjustments are as large as said.
TEST(Cameras, DeviationsAreThoseOfRepeatedMeasurements) {
  const std::vector<Camera> truth = CamerasOf(Exact().scene);
  const auto surface = SeenPoints(Exact().truth, Exact().scene.views, 200);
  constexpr double kSigma = 0.1;
  constexpr int kTrials = 12;
  std::vector<double> squares(truth.size(), 0);
  std::vector<double> said;
  for (int trial = 0; trial < kTrials; ++trial) {
    const CounterRandom random(7, trial);
    MeshTracks tracks;
    tracks.pixel.assign(truth.size(), 1);
    tracks.groups.of_view.assign(truth.size(), 0);
    tracks.groups.count = 1;
    uint64_t draw = 0;
    for (const Eigen::Vector3d& point : surface[4]) {
      tracks.points.push_back(point);
      tracks.tracks.BeginPoint();
      for (size_t v = 0; v < truth.size(); ++v) {
        const Eigen::Vector2d noise(random.Normal(draw), random.Normal(draw + 1));
        draw += 2;
        tracks.tracks.Add({truth[v].Project(point) + kSigma * noise, static_cast<int>(v)});
      }
    }
    const Bundle bundle = AdjustBundle(Exact().scene, tracks);
    CameraSimilarity fit;
    std::string error;
    ASSERT_TRUE(FitCameraSimilarity(truth, bundle.cameras, surface, &fit, &error));
    for (size_t v = 0; v < truth.size(); ++v) {
      squares[v] += std::pow(fit.errors.view_px[v], 2) / kTrials;
    }
    if (trial == 0) said = PoseDeviations(truth, tracks, kSigma, 1e6, surface);
  }
  double measured = 0;
  double foreseen = 0;
  for (size_t v = 0; v < truth.size(); ++v) {
    measured += squares[v];
    foreseen += said[v] * said[v];
  }
  // A fifth of the tracks is kept out, and Cauchy's loss is a little worse than least squares: 5/4 and some percent.
  EXPECT_NEAR(measured / foreseen, 1.3, 0.45);
}

TEST(Cameras, TheModelWrittenIsTheSceneWithTheNewPoses) {
  Scene scene = MeasuredScene();
  for (View& view : scene.views) {
    view.origin.camera_model = "SIMPLE_RADIAL";
    view.origin.lens.brown[0] = -0.05;
  }
  std::vector<Camera> moved = CamerasOf(scene);
  for (Camera& camera : moved) {
    camera.rotation = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).matrix() * camera.rotation;
  }
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "written_cameras";
  EXPECT_EQ(WriteCameras(scene, moved, folder), "");
  SceneSource source;
  source.path = folder;
  const PosedScene read = ReadScene(source);
  ASSERT_EQ(read.images.size(), scene.views.size());
  for (const PosedImage& image : read.images) {
    EXPECT_EQ(image.camera_model, "SIMPLE_RADIAL");
    EXPECT_EQ(image.lens.brown[0], -0.05);
    EXPECT_EQ(image.camera_id, 7U);
    const auto view = std::find_if(scene.views.begin(), scene.views.end(),
                                   [&](const View& other) { return other.name == image.name; });
    ASSERT_NE(view, scene.views.end());
    EXPECT_EQ(image.image_id, view->origin.image_id);
    const Camera& camera = moved[view - scene.views.begin()];
    EXPECT_LT((image.camera.rotation - camera.rotation).norm(), 1e-12);
    EXPECT_LT((image.camera.translation - camera.translation).norm(), 1e-12);
  }
  ASSERT_EQ(read.points.size(), scene.points.size());
  // ERROR is the mean distance from projection to measurement, in the photograph. Points are in the file by their ids' order.
  std::ifstream file(folder / "sparse" / "points3D.txt");
  std::string line;
  std::getline(file, line);
  int checked = 0;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::uint64_t id = 0;
    Eigen::Vector3d point;
    std::string color;
    double error = 0;
    words >> id >> point.x() >> point.y() >> point.z() >> color >> color >> color >> error;
    const size_t p = 100 - id;
    double sum = 0;
    for (const Measurement& measured : scene.tracks.Of(p)) {
      const Lens& lens = scene.views[measured.view].origin.lens;
      const Camera& camera = moved[measured.view];
      sum += (PhotographedAt(camera, lens, camera.Project(point)) -
              PhotographedAt(camera, lens, measured.image_point))
                 .norm();
    }
    EXPECT_GT(error, 0.01);
    EXPECT_NEAR(error, sum / 3, 1e-9);
    ++checked;
  }
  EXPECT_EQ(checked, 40);
  // Measurements are those of the photograph again.
  const Measurement& measured = *read.tracks.Of(0).begin();
  EXPECT_GT(read.tracks.Count(), 0U);
  EXPECT_TRUE(measured.image_point.allFinite());
}

}  // namespace
}  // namespace burin
