// Cameras scored against true ones, in process and by `burin evaluate --cameras`.
#include "core/evaluate/camera_evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/mesh/alignment.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic_stress.h"
#include "tests/program_test.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Around a sphere of radius 1 that fills most of every image.
Scene Orbit(int count, int width = 400, int height = 300) {
  Scene scene;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * M_PI * k / count;
    View& view = scene.views.emplace_back();
    view.name = "view_" + std::to_string(k);
    view.camera = test::LookAt({4 * std::sin(angle), 0.4 * (k % 2), 4 * std::cos(angle)}, {0, 0, 0},
                               width, height, 1.25 * width);
  }
  return scene;
}

Scene Noisy(Scene scene, double px) {
  const CounterRandom random(5, 0);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    scene.views[v].camera = WithPoseNoise(scene.views[v].camera, px, random, static_cast<int>(v));
  }
  return scene;
}

Scene InMovedWorld(Scene scene, const Similarity& motion) {
  for (View& view : scene.views) view.camera = Moved(view.camera, motion);
  return scene;
}

std::string ErrorOf(const Scene& scene, const Scene& truth, const TriangleMesh& surface) {
  try {
    EvaluateCameras(scene, truth, surface, false);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CameraEvaluation, AnotherFrameAndAnotherSizeAreNoErrors) {
  Similarity motion;
  motion.scale = 0.2;
  motion.rotation = Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX()).matrix();
  motion.translation = {100, 200, 300};
  const CameraEvaluation evaluation =
      EvaluateCameras(Orbit(6), InMovedWorld(Orbit(6, 800, 600), motion), Sphere(1, 3), false);
  EXPECT_LT(evaluation.rms_px, 1e-8);
  EXPECT_EQ(evaluation.views_with_points, 6);
  EXPECT_NEAR(evaluation.truth_from_scene.scale, 0.2, 1e-9);
  EXPECT_LT((evaluation.truth_from_scene.translation - motion.translation).norm(), 1e-7);
  for (const ViewCameraErrors& view : evaluation.views) {
    EXPECT_GT(view.points, 300);
    EXPECT_LT(view.center_distance, 1e-7);
    EXPECT_LT(view.angle_deg, 1e-7);
  }
}

// The same models from both sides: on the truth in the true cameras, on the mesh in the scene's.
TEST(CameraEvaluation, IsAlikeOnTruthAndMesh) {
  Similarity motion;
  motion.scale = 3;
  const Scene noisy = Noisy(Orbit(6), 1);
  const TriangleMesh sphere = Sphere(1, 4);
  const CameraEvaluation on_mesh =
      EvaluateCameras(noisy, InMovedWorld(Orbit(6), motion), sphere, false);
  const CameraEvaluation on_truth =
      EvaluateCameras(noisy, InMovedWorld(Orbit(6), motion), Moved(sphere, motion), true);
  EXPECT_GT(on_mesh.rms_px, 0.5);
  EXPECT_NEAR(on_truth.rms_px, on_mesh.rms_px, 0.02 * on_mesh.rms_px);
  EXPECT_NEAR(on_truth.truth_from_scene.scale, 3, 0.02);
  EXPECT_NEAR(on_mesh.truth_from_scene.scale, 3, 0.02);
  EXPECT_NEAR(on_truth.views[2].center_distance, on_mesh.views[2].center_distance,
              0.05 * on_mesh.views[2].center_distance);
}

TEST(CameraEvaluation, NamesTheWorstAndWhatIsMissing) {
  Scene scene = Orbit(9);
  Scene truth = Orbit(9);
  Camera& off = scene.views[4].camera;
  const Eigen::Vector3d center = off.Center();
  off.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).matrix() * off.rotation;
  off.translation = -off.rotation * center;
  truth.views.erase(truth.views.begin() + 1);
  scene.views.erase(scene.views.begin() + 8);
  const CameraEvaluation evaluation = EvaluateCameras(scene, truth, Sphere(1, 3), false);
  EXPECT_THAT(evaluation.only_in_scene, ElementsAre("view_1"));
  EXPECT_THAT(evaluation.only_in_truth, ElementsAre("view_8"));
  ASSERT_EQ(evaluation.views.size(), 7U);
  EXPECT_EQ(evaluation.views[evaluation.worst].name, "view_4");
  EXPECT_GT(evaluation.views[evaluation.worst].px, 10);
}

// x at the image's edge, r = 0.4 of the focal length: a lens k1 puts it k1 r^3 further out.
TEST(CameraEvaluation, LensesCount) {
  Scene truth = Orbit(6);
  for (View& view : truth.views) view.origin.lens.brown[0] = 0.05;
  const TriangleMesh sphere = Sphere(1, 3);
  EXPECT_LT(EvaluateCameras(truth, truth, sphere, false).rms_px, 1e-6);
  const Scene none = Orbit(6);
  const CameraEvaluation evaluation = EvaluateCameras(none, truth, sphere, true);
  EXPECT_GT(evaluation.rms_px, 0.02);
  EXPECT_LT(evaluation.rms_px, 500 * 0.05 * std::pow(0.25, 3));
}

TEST(CameraEvaluation, ImpossibleComparisonsAreRefused) {
  const Scene scene = Orbit(4);
  const TriangleMesh sphere = Sphere(1, 3);
  Scene others = Orbit(4);
  for (size_t v = 1; v < 4; ++v) others.views[v].name = "zz" + std::to_string(v);
  EXPECT_THAT(ErrorOf(scene, others, sphere), HasSubstr("1 image names in common"));
  EXPECT_THAT(ErrorOf(scene, Orbit(4, 400, 400), sphere), HasSubstr("not the same shape"));
  Similarity away;
  away.translation = {0, 100, 0};
  EXPECT_THAT(ErrorOf(scene, scene, Moved(sphere, away)), HasSubstr("0 surface points in 4 views"));
}

class EvaluateCamerasTest : public ProgramTest {
 protected:
  void Synth(const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"synth",  "--output",
                                          In(name), "--synth.width",
                                          "96",     "--synth.height",
                                          "72",     "--synth.truth_point_count",
                                          "2000",   "--synth.point_count",
                                          "100"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = Run(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
};

TEST_F(EvaluateCamerasTest, WithATruthAndWithout) {
  Synth("exact", {});
  Synth("noisy", {"--synth.pose_noise_px", "1"});
  const std::vector<std::string> without = {
      "evaluate", "--mesh", In("noisy/init.ply"), "--scene", In("noisy"), "--cameras", In("exact")};
  const auto json_of = [this](std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const nlohmann::json on_mesh = json_of(without);
  EXPECT_FALSE(on_mesh.contains("scores"));
  EXPECT_EQ(on_mesh["cameras"]["surface"], "mesh");
  EXPECT_EQ(on_mesh["cameras"]["views"].size(), 7U);
  EXPECT_GT(on_mesh["cameras"]["rms_px"], 0.3);
  EXPECT_LT(on_mesh["cameras"]["rms_px"], 3);

  std::vector<std::string> with = without;
  with.insert(with.end(), {"--truth", In("exact/truth.ply"), "--sample_count", "2000"});
  const nlohmann::json on_truth = json_of(with);
  EXPECT_TRUE(on_truth.contains("scores"));
  EXPECT_EQ(on_truth["cameras"]["surface"], "truth");
  EXPECT_NEAR(on_truth["cameras"]["rms_px"].get<double>(),
              on_mesh["cameras"]["rms_px"].get<double>(), 0.1);

  with[6] = In("noisy");
  EXPECT_EQ(json_of(with)["cameras"]["rms_px"], 0);
  // A cloud has no surface that a view could see.
  with = without;
  with.insert(with.end(), {"--truth", In("exact/truth_points.ply"), "--sample_count", "2000"});
  EXPECT_EQ(json_of(with)["cameras"], on_mesh["cameras"]);

  const Outcome table = Run(without);
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("cameras against the true ones"));
  EXPECT_THAT(table.out, HasSubstr("worst: view_00"));
}

// As structure from motion would have it: a frame and a unit of its own.
TEST_F(EvaluateCamerasTest, AMeshInTheFrameOfItsOwnCamerasIsScored) {
  Synth("exact", {});
  Similarity motion;
  motion.scale = 0.05;
  motion.rotation =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(3, 1, 2).normalized()).toRotationMatrix();
  motion.translation = {100, -20, 3};
  const Scene exact = LoadScene({In("exact"), {}, {}});
  WriteColmapModel(InMovedWorld(exact, motion), In("sfm"), /*binary=*/true);
  std::filesystem::copy(In("exact/images"), In("sfm/images"));
  WriteMesh(In("moved.ply"), Moved(ReadMesh(In("exact/truth.ply")), motion));
  const std::vector<std::string> aligned = {
      "evaluate",  "--mesh",         In("moved.ply"), "--truth", In("exact/truth.ply"),
      "--align",   "cameras",        "--scene",       In("sfm"), "--cameras",
      In("exact"), "--sample_count", "2000",          "--json"};
  const Outcome outcome = Run(aligned);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(json["alignment"]["scale"].get<double>(), 20, 1e-3);
  EXPECT_LT(json["accuracy"]["mean"].get<double>(), 1e-4);
  const std::string sfm = In("sfm");
  ExpectRefused({"evaluate", "--mesh", In("moved.ply"), "--truth", In("exact/truth.ply"), "--align",
                 "cameras", "--scene", sfm},
                {"align = cameras", "--cameras"});
  ExpectRefused({"evaluate", "--mesh", In("moved.ply"), "--truth", In("exact/truth.ply"), "--align",
                 "cameras", "--scene", sfm, "--cameras", In("exact"), "--strecha.run"},
                {"align = cameras", "strecha.run"});
}

TEST_F(EvaluateCamerasTest, BadInputIsOneLine) {
  Synth("scene", {"--text"});
  const std::string mesh = In("scene/init.ply");
  const std::string scene = In("scene");
  ExpectRefused({"evaluate", "--mesh", mesh, "--cameras", scene}, {"--cameras", "--scene"});
  ExpectRefused({"evaluate", "--mesh", mesh, "--scene", scene}, {"--truth", "required"});
  ExpectRefused({"evaluate", "--mesh", mesh, "--scene", scene, "--cameras", In("none")},
                {"none", "no such file"});
  ExpectRefused({"evaluate", "--mesh", mesh, "--scene", scene, "--cameras", scene, "--dtu.run"},
                {"dtu.run", "--truth"});
  ExpectRefused({"evaluate", "--mesh", mesh, "--scene", scene, "--cameras", scene, "--depth",
                 In("scene/depth")},
                {"--depth", "--truth"});
  ExpectRefused({"evaluate", "--mesh", mesh, "--scene", scene, "--cameras", scene, "--strecha.run"},
                {"strecha.run", "--truth"});
  Synth("others", {"--text"});
  std::string names = ReadAll(In("others/sparse/images.txt"));
  for (size_t at = 0; (at = names.find("view_", at)) != std::string::npos;) {
    names.replace(at, 5, "shot_");
  }
  Write("others/sparse/images.txt", names);
  ExpectRefused({"evaluate", "--mesh", mesh, "--scene", scene, "--cameras", In("others")},
                {"0 image names in common", "view_000.png", "shot_000.png"});
}

}  // namespace
}  // namespace burin
