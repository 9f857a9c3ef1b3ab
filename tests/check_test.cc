// burin check, and burin refine on scenes that cannot be right or have a view that does not fit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh_io.h"
#include "tests/program_test.h"

namespace burin {
namespace {

using testing::HasSubstr;
using testing::Not;

class CheckTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const Outcome synth =
        Run({"synth", "--output", In("s"), "--text", "--synth.width", "480", "--synth.height",
             "360", "--synth.samples_per_axis", "1", "--synth.truth_point_count", "100"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
  }
  std::string Photograph(int view) const {
    return In("s/images/view_00" + std::to_string(view) + ".png");
  }
  // One photograph under all names.
  void MakeWrong() const {
    for (int view = 1; view < 7; ++view) {
      std::filesystem::copy_file(Photograph(0), Photograph(view),
                                 std::filesystem::copy_options::overwrite_existing);
    }
  }
  void SwapTwoPhotographs() const {
    std::filesystem::rename(Photograph(2), In("two.png"));
    std::filesystem::rename(Photograph(5), Photograph(2));
    std::filesystem::rename(In("two.png"), Photograph(5));
  }
  Outcome Refine(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"refine",   In("s"),   "--mesh",         In("s/init.ply"),
                                          "--output", In("out"), "--level.finest", "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  nlohmann::json Summary() const { return nlohmann::json::parse(ReadAll(In("out/summary.json"))); }
};

TEST_F(CheckTest, GoodSceneAsTextJsonAndPicture) {
  const Outcome text = Run({"check", In("s"), "--mesh", In("s/init.ply"), "--output", In("c")});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("good\n"));
  EXPECT_THAT(text.out, HasSubstr("view_003.png"));
  const Outcome json = Run({"check", In("s"), "--mesh", In("s/init.ply"), "--json"});
  EXPECT_EQ(json.out, ReadAll(In("c/verdict.json")));
  const auto verdict = nlohmann::json::parse(json.out);
  EXPECT_EQ(verdict["verdict"], "good");
  EXPECT_GT(verdict["E"], 0.85);
  EXPECT_EQ(verdict["views"].size(), 7U);
  EXPECT_FALSE(cv::imread(In("c/offsets.png")).empty());
}

TEST_F(CheckTest, WhatCannotBeRightIsHandedBack) {
  MakeWrong();
  const Outcome check = Run({"check", In("s"), "--mesh", In("s/init.ply")});
  EXPECT_EQ(check.exit_code, 4);
  EXPECT_THAT(check.out, HasSubstr("wrong: "));
  EXPECT_THAT(check.err, HasSubstr("burin: error: this cannot be right: "));

  const Outcome stopped = Refine({});
  EXPECT_EQ(stopped.exit_code, 4);
  EXPECT_THAT(stopped.err, HasSubstr("burin: error: this cannot be right: "));
  EXPECT_EQ(Summary()["verdict"]["verdict"], "wrong");
  EXPECT_EQ(Summary()["levels"].size(), 0U);
  const TriangleMesh input = ReadMesh(In("s/init.ply"));
  const TriangleMesh output = ReadMesh(In("out/refined.ply"));
  EXPECT_EQ(output.vertices, input.vertices);
  EXPECT_EQ(output.faces, input.faces);
  EXPECT_FALSE(std::filesystem::exists(In("out/checkpoint.cbor")));

  const Outcome warned = Refine({"--verdict.action", "warn"});
  EXPECT_EQ(warned.exit_code, 0) << warned.err;
  EXPECT_THAT(warned.err + warned.out, HasSubstr("this cannot be right: "));
  EXPECT_EQ(Summary()["verdict"]["verdict"], "wrong");
  EXPECT_GT(Summary()["levels"].size(), 0U);

  const Outcome silent = Refine({"--verdict.action", "off"});
  EXPECT_EQ(silent.exit_code, 0) << silent.err;
  EXPECT_THAT(silent.err + silent.out, Not(HasSubstr("cannot be right")));
  EXPECT_TRUE(Summary()["verdict"].is_null());
}

TEST_F(CheckTest, ViewsThatDoNotFitAreNamedAndLeftOut) {
  SwapTwoPhotographs();
  const Outcome left_out = Refine({"--cameras.refine", "none"});
  EXPECT_EQ(left_out.exit_code, 0) << left_out.err;
  EXPECT_THAT(left_out.err + left_out.out, HasSubstr("view_002.png does not fit the other views"));
  EXPECT_THAT(left_out.err + left_out.out, HasSubstr("view_005.png does not fit the other views"));
  EXPECT_EQ(Summary()["verdict"]["left_out"].size(), 2U);
  const nlohmann::json without = Summary();
  for (const auto& pair : without["pairs"]["list"]) {
    for (const char* name : {"view_002.png", "view_005.png"}) {
      EXPECT_NE(pair[0], name);
      EXPECT_NE(pair[1], name);
    }
  }
  const Outcome kept = Refine({"--scene.misfit", "warn", "--cameras.refine", "none"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_THAT(kept.err + kept.out, HasSubstr("view_002.png does not fit the other views\n"));
  EXPECT_EQ(Summary()["verdict"]["left_out"].size(), 0U);
  EXPECT_EQ(Summary()["verdict"]["misfits"].size(), 2U);

  // Pairs of a file are those of the views that are left.
  ASSERT_EQ(
      Run({"select", In("s"), "--mesh", In("s/init.ply"), "--output", In("p"), "--no-pictures"})
          .exit_code,
      0);
  const Outcome file = Refine(
      {"--pairs.method", "file", "--pairs.file", In("p/pairs.json"), "--cameras.refine", "none"});
  EXPECT_EQ(file.exit_code, 0) << file.err;
  EXPECT_EQ(Summary()["verdict"]["left_out"].size(), 2U);
  const nlohmann::json by_file = Summary();
  for (const auto& pair : by_file["pairs"]["list"]) {
    EXPECT_NE(pair[0], "view_002.png");
    EXPECT_NE(pair[1], "view_005.png");
  }
}

TEST_F(CheckTest, AnInterruptedRunGoesOnWithoutTheViewsLeftOut) {
  SwapTwoPhotographs();
  ASSERT_EQ(Refine({}).exit_code, 0);
  const std::string whole = ReadAll(In("out/refined.ply"));
  const pid_t child = Start({"refine", In("s"), "--mesh", In("s/init.ply"), "--output", In("cut"),
                             "--level.finest", "2"});
  while (ReadAll(In("stderr.txt")).find("pixel pairs") == std::string::npos) usleep(2000);
  kill(child, SIGTERM);
  ASSERT_EQ(Wait(child).exit_code, 143);
  const Outcome resumed = Run({"refine", "--resume", In("cut")});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(ReadAll(In("cut/refined.ply")), whole);
  const auto summary = nlohmann::json::parse(ReadAll(In("cut/summary.json")));
  EXPECT_EQ(summary["verdict"], Summary()["verdict"]);
}

TEST_F(CheckTest, AMeshWithTurnedAxesIsToldWhichFit) {
  TriangleMesh turned = ReadMesh(In("s/init.ply"));
  for (Eigen::Vector3d& vertex : turned.vertices) {
    vertex = Eigen::Vector3d(vertex.y(), vertex.z(), vertex.x());
  }
  WriteMesh(In("turned.ply"), turned);
  const Outcome outcome = Run({"check", In("s"), "--mesh", In("turned.ply")});
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("with its axes turned the mesh would fit: take z, x, y for"));
}

TEST_F(CheckTest, ComparisonsKeepTheirRows) {
  MakeWrong();
  const Outcome outcome =
      Run({"compare-solvers", In("s"), "--mesh", In("s/init.ply"), "--output", In("cmp"),
           "--solvers", "lm_pcg", "--level.finest", "2", "--level.count", "3"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err + outcome.out, HasSubstr("this cannot be right: "));
  const auto document = nlohmann::json::parse(ReadAll(In("cmp/compare.json")));
  EXPECT_EQ(document["verdict"]["verdict"], "wrong");
}

}  // namespace
}  // namespace burin
