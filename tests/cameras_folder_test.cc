// cameras/ in the output folder of `burin refine`, run as a process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh_io.h"
#include "tests/program_test.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CamerasFolderTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const Outcome synth =
        ProgramTest::Run({"synth", "--output", In("s"), "--synth.width", "160", "--synth.height",
                          "120", "--synth.views", "4", "--synth.truth_point_count", "1000"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
  }
  std::vector<std::string> Refine(const std::vector<std::string>& more = {}) const {
    return RefineScene(In("s"), more);
  }
  std::vector<std::string> RefineScene(const std::string& scene,
                                       const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = {"refine",
                                    scene,
                                    "--mesh",
                                    In("s/init.ply"),
                                    "--images",
                                    In("s/images"),
                                    "--output",
                                    In("out"),
                                    "--level.finest",
                                    "2",
                                    "--level.count",
                                    "1",
                                    "--level.rounds",
                                    "1",
                                    "--solver.max_iterations",
                                    "2"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(CamerasFolderTest, ARunThatWritesNoCamerasLeavesNoneOfAnEarlierOne) {
  const Outcome with = Run(Refine());
  ASSERT_EQ(with.exit_code, 0) << with.err;
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    EXPECT_TRUE(fs::exists(In("out/cameras/sparse") + "/" + name)) << name;
  }
  const Outcome without = Run(Refine({"--cameras.refine", "none"}));
  ASSERT_EQ(without.exit_code, 0) << without.err;
  EXPECT_FALSE(fs::exists(In("out/cameras")));
}

TEST_F(CamerasFolderTest, FilesOfOthersStay) {
  ASSERT_EQ(Run(Refine()).exit_code, 0);
  Write("out/cameras/notes.txt", "mine");
  Write("out/cameras/sparse/frames.txt", "mine");
  ASSERT_EQ(Run(Refine({"--cameras.refine", "none"})).exit_code, 0);
  EXPECT_FALSE(fs::exists(In("out/cameras/sparse/cameras.txt")));
  EXPECT_FALSE(fs::exists(In("out/cameras/sparse/images.txt")));
  EXPECT_EQ(ReadAll(In("out/cameras/notes.txt")), "mine");
  EXPECT_EQ(ReadAll(In("out/cameras/sparse/frames.txt")), "mine");
}

TEST_F(CamerasFolderTest, AMeshHandedBackComesWithoutCameras) {
  ASSERT_EQ(Run(Refine()).exit_code, 0);
  // One photograph under all names.
  for (int v = 1; v < 4; ++v) {
    fs::copy_file(In("s/images/view_000.png"), In("s/images/view_00" + std::to_string(v) + ".png"),
                  fs::copy_options::overwrite_existing);
  }
  const Outcome back = Run(Refine());
  ASSERT_EQ(back.exit_code, 4) << back.err;
  EXPECT_FALSE(fs::exists(In("out/cameras")));
}

// Tracks make better cameras than those given, and the mesh is beside the surface.
TEST_F(CamerasFolderTest, CamerasThatAreHandedBackAreNotSaidToBeKept) {
  const Outcome synth = Run({"synth", "--output", In("o"), "--synth.scene", "occluders",
                             "--synth.views", "8", "--synth.width", "320", "--synth.height", "240",
                             "--synth.pose_noise_px", "1", "--synth.truth_point_count", "1000"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  TriangleMesh mesh = ReadMesh(In("o/init.ply"));
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex.z() += 0.2;
  WriteMesh(In("beside.ply"), mesh);
  const Outcome back = Run({"refine", In("o"), "--mesh", In("beside.ply"), "--output", In("out")});
  ASSERT_EQ(back.exit_code, 4) << back.err;
  EXPECT_THAT(back.err, HasSubstr("would move by "));
  EXPECT_THAT(back.err, HasSubstr("left as given, the input is handed back"));
  const auto summary = nlohmann::json::parse(ReadAll(In("out/summary.json")));
  const auto& tracks = summary["cameras"]["tracks"];
  EXPECT_EQ(tracks["kept"], false);
  EXPECT_EQ(tracks["reason"], "the input is handed back");
  EXPECT_EQ(tracks["groups"][0]["kept"], false);
  EXPECT_FALSE(fs::exists(In("out/cameras")));
}

TEST_F(CamerasFolderTest, AFileOfThatNameIsRefusedBeforeTheRun) {
  fs::create_directory(In("out"));
  Write("out/cameras", "mine");
  ExpectRefused(Refine(), {"out/cameras: is not a folder"});
  EXPECT_FALSE(fs::exists(In("out/refined.ply")));
  ASSERT_EQ(Run(Refine({"--cameras.refine", "none"})).exit_code, 0);
  EXPECT_EQ(ReadAll(In("out/cameras")), "mine");
}

TEST_F(CamerasFolderTest, LevelsOfJointRoundsTheWrongWayRoundAreRefused) {
  const std::vector<std::string> wrong = {"--cameras.coarsest_joint", "0", "--cameras.finest_joint",
                                          "2"};
  ExpectRefused(Refine(wrong),
                {"cameras.coarsest_joint = 0: must be at least cameras.finest_joint, 2"});
}

TEST_F(CamerasFolderTest, TheSceneIsNotReplaced) {
  ASSERT_EQ(Run(Refine()).exit_code, 0);
  for (const char* scene : {"out/cameras", "out/cameras/sparse"}) {
    ExpectRefused(RefineScene(In(scene), {"--cameras.refine", "none"}),
                  {"the scene: this run would write to", "name another --output"});
  }
  EXPECT_TRUE(fs::exists(In("out/cameras/sparse/cameras.txt")));
}

}  // namespace
}  // namespace burin
