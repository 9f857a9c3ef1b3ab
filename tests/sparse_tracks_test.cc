// The scene's own sparse tracks beside windows that match through the mesh (core/cameras/sparse_tracks.h).
#include "core/cameras/sparse_tracks.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "core/cameras/track_step.h"
#include "core/scene/camera_similarity.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/seen_points.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

TEST(SparseTracks, LongOnesUntilEveryViewHasEnough) {
  Scene scene;
  scene.views.resize(4);
  const auto add = [&](const std::vector<int>& views, int times) {
    for (int k = 0; k < times; ++k) {
      const auto number = static_cast<double>(scene.points.size());
      scene.points.emplace_back().position.x() = number;
      scene.tracks.BeginPoint();
      for (const int v : views) scene.tracks.Add({Eigen::Vector2d(k, v), v});
    }
  };
  add({2}, 10);
  add({0, 1}, kSparseTracks);
  add({0, 1, 1}, kSparseTracks / 2);  // view 1 measured twice: its first place counts
  add({0, 1, 2}, kSparseTracks);
  add({3, 2}, 5);
  std::vector<Eigen::Vector3d> points(1);
  Tracks tracks;
  tracks.BeginPoint();
  AppendSparseTracks(scene, &points, &tracks);
  // 100 of the second kind and 200 of the third give views 0 to 2 enough; view 3 has the five that there are.
  ASSERT_EQ(points.size(), 1U + kSparseTracks / 2 + kSparseTracks + 5);
  ASSERT_EQ(tracks.PointCount(), points.size());
  EXPECT_EQ(tracks.Of(0).size(), 0U);
  EXPECT_EQ(tracks.Of(1).size(), 2U);
  EXPECT_EQ(points[1].x(), 10 + kSparseTracks);
  EXPECT_EQ(tracks.Of(kSparseTracks / 2 + 1).size(), 3U);
  EXPECT_EQ(tracks.Of(points.size() - 1).begin()->view, 3);
}

// Two rows of views that no pair joins: only the sparse points say how they lie to each other.
TEST(SparseTracks, JoinViewsThatNoWindowsJoin) {
  SyntheticOptions options;
  options.width = 480;
  options.height = 360;
  options.views = 9;
  options.init_edge_px = 25;
  options.seed = 3;
  const SyntheticScene exact = MakeSyntheticScene(options);
  options.pose_noise_px = 2;
  options.track_noise_px = 0.3;
  const SyntheticScene noisy = MakeSyntheticScene(options);
  std::vector<CameraPair> pairs;
  for (const CameraPair& pair : SelectPairs(noisy.scene, noisy.init, PairsOptions()).ForTracks()) {
    if ((pair.reference < 4) == (pair.second < 4)) pairs.push_back(pair);
  }
  const auto error = [&](const std::vector<Camera>& cameras) {
    CameraSimilarity fit;
    std::string reason;
    EXPECT_TRUE(FitCameraSimilarity(CamerasOf(exact.scene), cameras,
                                    SeenPoints(exact.truth, exact.scene.views), &fit, &reason));
    return fit.errors.rms_px;
  };
  const TrackStep step = RefineByTracks(noisy.scene, noisy.init, pairs, TrackRule::kBetter);
  ASSERT_EQ(step.groups.size(), 1U);
  EXPECT_TRUE(step.Kept()) << step.Reason();
  EXPECT_GT(step.bundle.sparse_scale, 1.5);  // their places are less sure than those of windows
  Scene alone = noisy.scene;
  alone.tracks = Tracks();
  const TrackStep apart = RefineByTracks(alone, noisy.init, pairs, TrackRule::kBetter);
  EXPECT_EQ(apart.groups.size(), 2U);
  std::printf("%.3f px -> %.3f (scale %.2f); without sparse tracks %.3f\n",
              error(CamerasOf(noisy.scene)), error(step.cameras), step.bundle.sparse_scale,
              error(apart.cameras));
  EXPECT_LT(error(step.cameras), 0.15);
  EXPECT_GT(error(apart.cameras), 3 * error(step.cameras));
}

}  // namespace
}  // namespace burin
