// What structure from motion measured stays with a scene: from every format that has it, through lenses, without
// views, and back into files.
#include "core/scene/tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "core/scene/formats/openmvs.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/lens_points.h"
#include "core/synthetic/synthetic.h"
#include "tests/colmap_testing.h"
#include "tests/measured_scene.h"

namespace burin {
namespace {

using testing::ElementsAre;

TEST(Tracks, ComeBackFromTextAndBinary) {
  const TempFolder folder;
  const Scene scene = MeasuredScene();
  WriteColmapScene(scene, folder.path() / "a", /*binary=*/false);
  const Scene first = LoadScene({folder.path() / "a", {}, {}});
  EXPECT_EQ(first.tracks.Count(), 120U);
  EXPECT_EQ(first.tracks.PointCount(), 40U);
  EXPECT_EQ(Lines(first, 6), Lines(scene, 6));
  EXPECT_GT(WorstError(first), 0.8);  // they are no projections
  for (const bool binary : {false, true}) {
    WriteColmapScene(first, folder.path() / "b", binary);
    const Scene again = LoadScene({folder.path() / "b", {}, {}});
    EXPECT_EQ(again.tracks.Count(), first.tracks.Count());
    EXPECT_EQ(Lines(again, 9), Lines(first, 9));
    // Views are in order of their names now, and keep their numbers.
    ASSERT_EQ(again.views[0].name, "a.png");
    EXPECT_EQ(again.views[0].origin.image_id, 10U);
    EXPECT_EQ(again.views[2].origin.image_id, 30U);
    for (const View& view : again.views) {
      EXPECT_EQ(view.origin.camera_id, 7U);
      EXPECT_EQ(view.origin.camera_model, "PINHOLE");
    }
  }
  // A format without places keeps who sees what, and the numbers of the images.
  WriteOpenMvs(first, folder.path() / "a/scene.mvs");
  const Scene other = LoadScene({folder.path() / "a/scene.mvs", {}, {}});
  EXPECT_TRUE(other.tracks.IsEmpty());
  EXPECT_EQ(other.points.size(), 40U);
  EXPECT_THAT(other.points[0].views, ElementsAre(0, 1, 2));
  EXPECT_EQ(other.views[0].origin.image_id, 10U);
}

TEST(Tracks, SharedCamerasThatDifferAreWrittenApart) {
  const TempFolder folder;
  Scene scene = MeasuredScene();
  scene.views[1].camera.fx = 301;
  scene.views[2].origin.image_id = scene.views[0].origin.image_id;
  WriteColmapScene(scene, folder.path(), true);
  const Scene read = LoadScene({folder.path(), {}, {}});
  EXPECT_EQ(read.views[1].camera.fx, 301);
  EXPECT_EQ(read.views[2].camera.fx, 300);
  EXPECT_NE(read.views[0].origin.image_id, read.views[2].origin.image_id);
}

TEST(Tracks, WithoutMeasurementsProjectionsAreWritten) {
  const TempFolder folder;
  Scene scene = MeasuredScene();
  scene.tracks = Tracks();
  WriteColmapScene(scene, folder.path(), true);
  const Scene read = LoadScene({folder.path(), {}, {}});
  EXPECT_EQ(read.tracks.Count(), 120U);
  EXPECT_LT(WorstError(read), 1e-8);
}

// What the images do not confirm is no measurement; the point keeps its view.
TEST(Tracks, OnlyObservationsOfTheSamePointCount) {
  const TempFolder folder;
  WriteColmapScene(MeasuredScene(), folder.path(), false);
  WriteBytes(folder.path() / "sparse/images.txt",
             "1 1 0 0 0 0 0 4 7 a.png\n"
             "10 20 -1 11 21 5 12 22 6\n"
             "2 1 0 0 0 1 0 4 7 b.png\n"
             "\n"
             "3 1 0 0 0 2 0 4 7 c.png\n"
             "13 23 5\n");
  WriteBytes(folder.path() / "sparse/points3D.txt",
             "5 0 0 0 0 0 0 0 1 1 2 0 3 0\n"  // all but image 2, which has none
             "6 0 0 0 0 0 0 0 1 1 3 7\n");    // of another point; beyond the end
  const Scene scene = LoadScene({folder.path(), {}, {}});
  ASSERT_EQ(scene.points.size(), 2U);
  EXPECT_THAT(scene.points[0].views, ElementsAre(0, 1, 2));
  EXPECT_THAT(scene.points[1].views, ElementsAre(0, 2));
  EXPECT_EQ(scene.points[1].id, 6U);
  ASSERT_EQ(scene.tracks.Of(0).size(), 2U);
  EXPECT_EQ(scene.tracks.Of(0).first[0].image_point, Eigen::Vector2d(11, 21));
  EXPECT_EQ(scene.tracks.Of(0).first[0].keypoint, 1U);
  EXPECT_EQ(scene.tracks.Of(0).first[1].view, 2);
  EXPECT_EQ(scene.tracks.Of(1).size(), 0U);
  EXPECT_EQ(scene.tracks.Of(2).size(), 0U);  // no such point
}

TEST(Tracks, WithoutViews) {
  Scene scene = MeasuredScene();
  const Scene without = WithoutViews(scene, {0, -1, 1});
  ASSERT_EQ(without.views.size(), 2U);
  EXPECT_EQ(without.views[1].name, scene.views[2].name);
  EXPECT_EQ(without.tracks.Count(), 80U);
  EXPECT_NEAR(WorstError(without), WorstError(scene), 1e-12);
  for (size_t p = 0; p < without.points.size(); ++p) {
    EXPECT_THAT(without.points[p].views, ElementsAre(0, 1));
    EXPECT_EQ(without.points[p].id, scene.points[p].id);
    ASSERT_EQ(without.tracks.Of(p).size(), 2U);
    EXPECT_EQ(without.tracks.Of(p).first[1].image_point, scene.tracks.Of(p).first[2].image_point);
  }
}

TEST(Tracks, SyntheticPhotographsShowThePointsWhereTheyAreMeasured) {
  SyntheticOptions options;
  options.width = 160;
  options.height = 120;
  options.samples_per_axis = 1;
  options.point_count = 200;
  options.truth_point_count = 100;
  options.point_noise_px = 0;
  const Scene exact = MakeSyntheticScene(options).scene;
  ASSERT_EQ(exact.tracks.PointCount(), exact.points.size());
  for (size_t p = 0; p < exact.points.size(); ++p) {
    std::vector<int> views;
    for (const Measurement& measured : exact.tracks.Of(p)) views.push_back(measured.view);
    EXPECT_EQ(views, exact.points[p].views);
  }
  EXPECT_LT(WorstError(exact), 1e-9);
  // Points and cameras that are wrong do not reproject.
  options.point_noise_px = 0.3;
  EXPECT_GT(WorstError(MakeSyntheticScene(options).scene), 0.5);
  options.point_noise_px = 0;
  options.pose_noise_px = 4;
  EXPECT_GT(WorstError(MakeSyntheticScene(options).scene), 4);
}

TEST(Tracks, LensesAreTakenOut) {
  Camera camera = MeasuredScene().views[0].camera;
  Lens lens;
  for (const std::array<double, 5>& brown :
       {std::array<double, 5>{-0.3, 0.12, 0.002, -0.003, -0.01},
        std::array<double, 5>{0.2, -0.05, -0.001, 0.004, 0}}) {
    lens.brown = brown;
    const PointUndistortion undistortion(camera, lens);
    for (double x = 0; x <= 320; x += 40) {
      for (double y = 0; y <= 240; y += 40) {
        const cv::Point2d at =
            ByOpenCv(lens, {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1});
        const auto back =
            undistortion({at.x * camera.fx + camera.cx, at.y * camera.fy + camera.cy});
        ASSERT_TRUE(back.has_value()) << x << " " << y;
        EXPECT_LT((*back - Eigen::Vector2d(x, y)).norm(), 1e-7);
        const Eigen::Vector2d put = PhotographedAt(camera, lens, {x, y});
        EXPECT_NEAR(put.x(), at.x * camera.fx + camera.cx, 1e-9);
        EXPECT_NEAR(put.y(), at.y * camera.fy + camera.cy, 1e-9);
      }
    }
  }
  // r (1 - 0.9 r^2) grows up to r = .609, where it is .406: nothing is photographed farther out.
  lens.brown = {-0.9, 0, 0, 0, 0};
  const PointUndistortion folding(camera, lens);
  EXPECT_TRUE(folding({160 + 300 * 0.40, 120}).has_value());
  EXPECT_FALSE(folding({160 + 300 * 0.41, 120}).has_value());
  EXPECT_FALSE(folding({std::numeric_limits<double>::quiet_NaN(), 120}).has_value());
  lens.brown = {};
  lens.measured = -0.9;  // that of the photograph, in closed form
  const PointUndistortion measured(camera, lens);
  EXPECT_NEAR(measured({160 + 300 * 0.5, 120})->x(), 160 + 300 * 0.5 * (1 - 0.9 * 0.25), 1e-9);
  EXPECT_FALSE(measured({160 + 300 * 0.62, 120}).has_value());
  const Eigen::Vector2d there(160 + 300 * 0.3, 120 - 300 * 0.4);
  EXPECT_LT((PhotographedAt(camera, lens, *measured(there)) - there).norm(), 1e-9);
}

}  // namespace
}  // namespace burin
