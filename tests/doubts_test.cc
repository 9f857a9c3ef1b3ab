// Cameras that no one has, and sparse points that are not where they were measured, are named on reading and have
// a say in the verdict.
#include "core/scene/doubts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "apps/run/judged_scene.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/track_errors.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic.h"
#include "tests/program_test.h"

namespace burin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

SyntheticScene SceneOfSize(int width, int height) {
  SyntheticOptions options;
  options.width = width;
  options.height = height;
  options.samples_per_axis = 1;
  options.truth_point_count = 100;
  options.point_count = 300;
  return MakeSyntheticScene(options);
}

// Photographs too small to be judged, so that the tracks alone speak.
const SyntheticScene& Small() {
  static const SyntheticScene made = SceneOfSize(160, 120);
  return made;
}

// Large enough.
const SyntheticScene& Large() {
  static const SyntheticScene made = SceneOfSize(480, 360);
  return made;
}

void ShiftPoses(Scene* scene) {
  std::vector<View>& views = scene->views;
  const Camera first = views[0].camera;
  for (size_t v = 0; v + 1 < views.size(); ++v) views[v].camera = views[v + 1].camera;
  views.back().camera = first;
}

void InvertPoses(Scene* scene) {
  for (View& view : scene->views) {
    const Eigen::Vector3d center = view.camera.Center();
    view.camera.rotation.transposeInPlace();
    view.camera.translation = center;
  }
}

void CornerPrincipalPoint(Scene* scene) {
  for (View& view : scene->views) view.camera.cx = view.camera.cy = 0;
}

void HalfIntrinsics(Scene* scene) {
  for (View& view : scene->views) {
    Camera& camera = view.camera;
    for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value /= 2;
  }
}

Scene Spoilt(const SyntheticScene& made, const std::function<void(Scene*)>& spoil) {
  Scene scene = made.scene;
  spoil(&scene);
  return scene;
}

SceneVerdict Judged(const Scene& scene, const TriangleMesh& mesh) {
  return JudgeScene(scene, mesh, SelectPairs(scene, mesh, PairsOptions()).pairs);
}

TEST(Doubts, NoneAboutGoodCameras) {
  EXPECT_THAT(DoubtsAbout(Small().scene), IsEmpty());
  const TrackErrors errors = MeasureTrackErrors(Small().scene);
  EXPECT_EQ(errors.known, 7);
  EXPECT_THAT(errors.off, IsEmpty());
  EXPECT_FALSE(errors.MostAreOff());
  for (const double px : errors.median_px) EXPECT_LT(px, 1);
  // Real ones reach .081 of the side, and squares of glass are not quite square.
  const Scene near = Spoilt(Small(), [](Scene* scene) {
    scene->tracks = Tracks();
    scene->views[0].camera.cx = 160 * 0.59;
    scene->views[1].camera.fx *= 1.2;
  });
  EXPECT_THAT(DoubtsAbout(near), IsEmpty());
}

TEST(Doubts, IntrinsicsByViewAndField) {
  const Scene scene = Spoilt(Small(), [](Scene* spoilt) {
    CornerPrincipalPoint(spoilt);
    spoilt->views[2].camera.fx *= 1.3;
    spoilt->tracks = Tracks();
  });
  EXPECT_THAT(
      DoubtsAbout(scene),
      ElementsAre(
          StartsWith("view_000.png and 6 more: principal point = (0.0, 0.0) of a picture 160x120: "
                     "0.50 of the width from the middle"),
          StartsWith("view_002.png: focal lengths = ")));
  const Scene half = Spoilt(Small(), [](Scene* spoilt) {
    HalfIntrinsics(spoilt);
    spoilt->tracks = Tracks();
  });
  EXPECT_THAT(DoubtsAbout(half), ElementsAre(HasSubstr(" of the height from the middle")));
  const Scene low = Spoilt(Small(), [](Scene* spoilt) {
    spoilt->views[3].camera.cy = 100;
    spoilt->tracks = Tracks();
  });
  EXPECT_THAT(DoubtsAbout(low), ElementsAre(HasSubstr("view_003.png: principal point")));
  EXPECT_THAT(DoubtsAbout(low), ElementsAre(HasSubstr("0.33 of the height")));
}

// Each was silent where photographs are too small to be judged.
TEST(Doubts, PointsThatAreElsewhereThanMeasuredMakeItWrong) {
  EXPECT_EQ(Judged(Small().scene, Small().init).verdict, Verdict::kCannotTell);
  for (const auto& spoil : {ShiftPoses, InvertPoses, CornerPrincipalPoint, HalfIntrinsics}) {
    const Scene scene = Spoilt(Small(), spoil);
    EXPECT_EQ(MeasureTrackErrors(scene).off.size(), 7U);
    EXPECT_THAT(DoubtsAbout(scene).back(),
                StartsWith("sparse points are not where they were measured: view_00"));
    EXPECT_THAT(DoubtsAbout(scene).back(), HasSubstr("and 4 more (median)"));
    const SceneVerdict verdict = JudgeScene(scene, Small().init, {{0, 1}});
    EXPECT_EQ(verdict.verdict, Verdict::kWrong);
    EXPECT_THAT(verdict.reason, HasSubstr("in 7 of 7 views"));
    Scene without = scene;
    without.tracks = Tracks();
    EXPECT_EQ(JudgeScene(without, Small().init, {{0, 1}}).verdict, Verdict::kCannotTell);
  }
}

TEST(Doubts, BehindTheCameraIsInfinitelyFar) {
  const Scene scene = Spoilt(Small(), [](Scene* spoilt) {
    Camera& camera = spoilt->views[4].camera;
    camera.rotation = Eigen::Vector3d(-1, 1, -1).asDiagonal() * camera.rotation;
    camera.translation = Eigen::Vector3d(-1, 1, -1).cwiseProduct(camera.translation);
  });
  EXPECT_THAT(MeasureTrackErrors(scene).off, ElementsAre(4));
  EXPECT_EQ(TrackErrorText(scene), "view_004.png behind the camera");
}

TEST(Doubts, FewMeasurementsSayNothing) {
  Scene scene = Spoilt(Small(), ShiftPoses);
  scene.points.resize(4);
  Tracks few;
  for (size_t p = 0; p < 4; ++p) {
    few.BeginPoint();
    for (const Measurement& measured : scene.tracks.Of(p)) few.Add(measured);
  }
  scene.tracks = few;
  EXPECT_EQ(MeasureTrackErrors(scene).known, 0);
  EXPECT_FALSE(MeasureTrackErrors(scene).MostAreOff());
}

TEST(Doubts, AViewThatNeitherTracksNorPhotographSpeakForIsLeftOut) {
  const Scene scene = Spoilt(Small(), [](Scene* spoilt) {
    Camera& camera = spoilt->views[2].camera;  // by 10 degrees
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.17, Eigen::Vector3d::UnitY()).matrix();
    camera.rotation = turn * camera.rotation;
    camera.translation = turn * camera.translation;
  });
  const JudgedScene judged = JudgeAndSelect(scene, Small().init, PipelineOptions());
  EXPECT_THAT(judged.left_out, ElementsAre("view_002.png"));
  EXPECT_FALSE(judged.stop);
  EXPECT_THAT(judged.lines.front(), HasSubstr("measured: view_002.png "));
  ASSERT_TRUE(judged.without.has_value());
  EXPECT_EQ(judged.without->views.size(), 6U);
  EXPECT_THAT(MeasureTrackErrors(*judged.without).off, IsEmpty());
  EXPECT_EQ(MeasureTrackErrors(*judged.without).known, 6);
}

// Measurements of another picture size: cameras and photographs fit, which is what counts.
TEST(Doubts, PhotographsOverruleTracks) {
  Scene scene = Large().scene;
  EXPECT_EQ(Judged(scene, Large().init).verdict, Verdict::kGood);
  Tracks twice;
  Tracks one_view;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    twice.BeginPoint();
    one_view.BeginPoint();
    for (const Measurement& measured : scene.tracks.Of(p)) {
      Measurement moved = measured;
      moved.image_point *= 2;
      twice.Add(moved);
      one_view.Add(measured.view == 3 ? moved : measured);
    }
  }
  scene.tracks = twice;
  const SceneVerdict all = Judged(scene, Large().init);
  EXPECT_EQ(all.verdict, Verdict::kDoubtful);
  EXPECT_THAT(all.reason, HasSubstr("in 7 of 7 views"));
  EXPECT_THAT(all.reason, HasSubstr("but the photographs fit"));
  EXPECT_THAT(all.misfits, IsEmpty());
  scene.tracks = one_view;
  const SceneVerdict one = Judged(scene, Large().init);
  EXPECT_THAT(one.tracks.off, ElementsAre(3));
  EXPECT_THAT(one.misfits, IsEmpty());
  EXPECT_THAT(DoubtsAbout(scene), ElementsAre(HasSubstr("measured: view_003.png ")));
}

// Mirrored poses may leave no pair at all; that, too, says why.
TEST(Doubts, AreSaidWhereNoPairIsLeft) {
  const Scene scene = Spoilt(Small(), [](Scene* spoilt) {
    for (View& view : spoilt->views) {
      const Eigen::DiagonalMatrix<double, 3> turn(-1, 1, -1);  // looks away
      view.camera.rotation = turn * view.camera.rotation;
      view.camera.translation = turn * view.camera.translation;
    }
  });
  PairSelection selection;
  double seconds = 0;
  try {
    SelectAndJudge(scene, Small().init, PairsOptions(), &selection, &seconds);
    ADD_FAILURE() << "there are pairs";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no camera pair"));
    EXPECT_THAT(error.what(), HasSubstr("measured: view_000.png behind the camera, view_001.png"));
  }
}

class DoubtsOnCommandLine : public ProgramTest {};

TEST_F(DoubtsOnCommandLine, AreSaidAndEndInExitCode4) {
  Scene scene = Spoilt(Small(), CornerPrincipalPoint);
  WriteColmapScene(scene, In("s"), /*binary=*/false);
  WriteMesh(In("m.ply"), Small().init);
  const Outcome convert = Run({"convert", In("s"), In("t")});
  EXPECT_EQ(convert.exit_code, 0) << convert.err;
  EXPECT_THAT(convert.err, HasSubstr("view_000.png and 6 more: principal point = (0.0, 0.0)"));
  EXPECT_THAT(convert.err, HasSubstr("sparse points are not where they were measured"));
  const Outcome select =
      Run({"select", In("t"), "--mesh", In("m.ply"), "--output", In("p"), "--no-pictures"});
  EXPECT_THAT(select.err, HasSubstr("view_000.png and 6 more: principal point = (0.0, 0.0)"));
  scene = Spoilt(Small(), ShiftPoses);
  WriteColmapScene(scene, In("s"), /*binary=*/false);
  const Outcome check = Run({"check", In("s"), "--mesh", In("m.ply")});
  EXPECT_EQ(check.exit_code, 4) << check.err;
  EXPECT_THAT(check.out, HasSubstr("wrong: cameras and sparse points are not of one"));
  EXPECT_THAT(check.out, HasSubstr(" px off"));
  const Outcome refine =
      Run({"refine", In("s"), "--mesh", In("m.ply"), "--output", In("o"), "--level.finest", "2"});
  EXPECT_EQ(refine.exit_code, 4) << refine.err;
  EXPECT_THAT(refine.err, HasSubstr("this cannot be right: cameras and sparse points"));
  const auto summary = nlohmann::json::parse(ReadAll(In("o/summary.json")));
  EXPECT_EQ(summary["input"]["doubts"].size(), 1U);
  EXPECT_GT(summary["verdict"]["views"][1]["track_px"], 1.6);
}

}  // namespace
}  // namespace burin
