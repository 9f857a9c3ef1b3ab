// The program as a user meets it: run as a process, judged by exit code, output and the files it leaves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/commands/commands.h"
#include "tests/program_test.h"

namespace burin {
namespace {

using testing::HasSubstr;

using CliTest = ProgramTest;

constexpr char kTriangle[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

TEST_F(CliTest, HelpAndVersionSucceed) {
  EXPECT_EQ(Run({"--version"}).exit_code, 0);
  const Outcome help = Run({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"demo", "check", "refine", "compare-solvers", "select", "synth",
                              "evaluate", "picture", "solvers", "options"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    const Outcome outcome = Run({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_EQ(outcome.err, "") << command;
  }
}

TEST_F(CliTest, UsageErrorsAreOneLineAndExitCode2) {
  ExpectRefused({}, {"no command given"});
  ExpectRefused({"sinth"}, {"sinth: unknown command (did you mean synth?)"});
  ExpectRefused({"--hepl"}, {"--hepl: unknown option (did you mean --help?)"});
  ExpectRefused({"synth"}, {"--output", "required"});
  ExpectRefused({"synth", "--output", In("s"), "--synth.veiws", "3"},
                {"--synth.veiws: unknown option (did you mean --synth.views?)"});
  ExpectRefused({"synth", "--output", In("s"), "stray"}, {"stray: unexpected argument"});
  ExpectRefused({"synth", "--output"}, {"--output"});
  ExpectRefused({"synth", "--output", In("s"), "--scene", "relief", "--synth.scene", "scan"},
                {"--scene"});
  ExpectRefused({"synth\nsecond line"}, {"unknown command"});
}

TEST_F(CliTest, OutputThatGoesNowhereIsAFailure) {
  const std::string command =
      "'" + std::string(test::kProgram) + "' solvers >/dev/full 2>'" + In("err.txt") + "'";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_EQ(ReadAll(In("err.txt")), "burin: error: standard output: cannot be written\n");
}

TEST_F(CliTest, OptionsOutOfRangeNameFlagAndConstraint) {
  ExpectRefused({"synth", "--output", In("s"), "--synth.width", "0"},
                {"--synth.width 0: must be a whole number in [16, 8192]"});
  ExpectRefused({"synth", "--output", In("s"), "--scene", "nonesuch"},
                {"--synth.scene nonesuch: must be one of relief, occluders, scan, rods, plates, "
                 "membrane, sky"});
  ExpectRefused({"synth", "--output", In("s"), "--synth.seed", "1.5"}, {"whole number"});
  ExpectRefused({"evaluate", "--mesh", "m.ply", "--truth", "t.ply", "--tau", "5,x"}, {"tau"});
  EXPECT_FALSE(std::filesystem::exists(In("s")));
}

TEST_F(CliTest, ConfigErrorsNameFileLineAndKey) {
  const std::string config = Write("run.toml", "# a run\n[synth]\nwieght = 3\n");
  ExpectRefused({"synth", "--output", In("s"), "--config", config},
                {"run.toml:3: synth.wieght: unknown option"});
  ExpectRefused({"synth", "--output", In("s"), "--config", In("none.toml")},
                {"none.toml", "No such file"});
  EXPECT_FALSE(std::filesystem::exists(In("s")));
}

TEST_F(CliTest, PrintedConfigReadsBackToItself) {
  const Outcome first =
      Run({"synth", "--synth.views", "5", "--scene", "occluders", "--print-config"});
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("views = 5\n"));
  EXPECT_THAT(first.out, HasSubstr("scene = \"occluders\"\n"));
  const Outcome second = Run({"synth", "--config", Write("c.toml", first.out), "--print-config"});
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(second.out, first.out);
}

TEST_F(CliTest, UnreadableMeshesAreRefused) {
  const std::string triangle = Write("triangle.ply", kTriangle);
  ExpectRefused({"evaluate", "--mesh", In("none.ply"), "--truth", triangle}, {"none.ply"});
  ExpectRefused({"evaluate", "--mesh", triangle, "--truth", In("none.ply")}, {"none.ply"});
  const std::string cut = Write("cut.ply", std::string(kTriangle).substr(0, 170));
  ExpectRefused({"evaluate", "--mesh", cut, "--truth", triangle}, {"cut.ply"});
  ExpectRefused({"evaluate", "--mesh", triangle, "--truth", cut}, {"cut.ply"});
  ExpectRefused({"evaluate", "--mesh", Write("empty.ply", ""), "--truth", triangle}, {"empty.ply"});
  ExpectRefused({"evaluate", "--mesh", folder_.string(), "--truth", triangle}, {"burin cli"});
}

TEST_F(CliTest, SynthRefusesContradictions) {
  const std::string triangle = Write("triangle.ply", kTriangle);
  ExpectRefused({"synth", "--output", In("s"), "--scene", "scan"}, {"--mesh"});
  ExpectRefused({"synth", "--output", In("s"), "--scene", "relief", "--mesh", triangle},
                {"--mesh", "relief"});
  ExpectRefused({"synth", "--output", triangle}, {"triangle.ply", "Not a directory"});
  ExpectRefused({"synth", "--output", In("s"), "--mesh", In("none.obj")}, {"none.obj"});
  EXPECT_FALSE(std::filesystem::exists(In("s")));
}

TEST_F(CliTest, SolversAreListedALineEach) {
  const Outcome outcome = Run({"solvers"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* name :
       {"gradient_descent", "steepest_descent", "ncg", "bfgs", "lbfgs", "lbfgs_sobolev", "lbfgs_h",
        "lm_cholesky", "lm_cgnr", "lm_pcg", "dogleg", "auto"}) {
    EXPECT_THAT("\n" + outcome.out, HasSubstr("\n" + std::string(name) + " ")) << name;
  }
}

TEST_F(CliTest, SynthesisedSceneScoresAsItsTruth) {
  const Outcome synth = Run({"synth", "--output", In("scene"), "--synth.width", "96",
                             "--synth.height", "72", "--synth.truth_point_count", "20000"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  EXPECT_EQ(synth.err, "");
  for (const char* name : {"scene/init.ply", "scene/truth.ply", "scene/truth_points.ply",
                           "scene/synth.json", "scene/images", "scene/sparse/cameras.bin"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
  }
  const auto f1 = [this](const std::string& mesh, const std::string& truth) {
    const Outcome outcome = Run({"evaluate", "--mesh", In(mesh), "--truth", In(truth), "--json",
                                 "--tau", "0.5,1", "--unit", "0.02", "--sample_count", "20000"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["scores"][0]["f1"].get<double>();
  };
  EXPECT_GT(f1("scene/truth.ply", "scene/truth.ply"), 0.999);
  EXPECT_GT(f1("scene/truth.ply", "scene/truth_points.ply"), 0.8);
  EXPECT_LT(f1("scene/init.ply", "scene/truth_points.ply"), 0.8);
  const Outcome table =
      Run({"evaluate", "--mesh", In("scene/init.ply"), "--truth", In("scene/truth_points.ply"),
           "--align", "similarity", "--unit", "0.02"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("F1"));

  const Outcome boundary =
      Run({"evaluate", "--mesh", In("scene/init.ply"), "--truth", In("scene/truth_points.ply"),
           "--scene", In("scene"), "--depth", In("scene/depth"), "--json"});
  EXPECT_EQ(boundary.exit_code, 0) << boundary.err;
  const nlohmann::json groups = nlohmann::json::parse(boundary.out);
  EXPECT_EQ(groups["boundary"]["near"]["count"].get<int>() +
                groups["boundary"]["rest"]["count"].get<int>(),
            groups["completeness"]["count"].get<int>());
  ExpectRefused({"evaluate", "--mesh", In("scene/init.ply"), "--truth",
                 In("scene/truth_points.ply"), "--depth", In("scene/depth")},
                {"--scene and --depth"});
  ExpectRefused({"evaluate", "--mesh", In("scene/init.ply"), "--truth", In("scene/truth.ply"),
                 "--scene", In("scene"), "--depth", In("scene/depth")},
                {"truth.ply", "point cloud"});
  ExpectRefused({"evaluate", "--mesh", In("scene/init.ply"), "--truth",
                 In("scene/truth_points.ply"), "--scene", In("scene"), "--depth", In("scene")},
                {"no depth map"});
}

TEST_F(CliTest, OtherProtocolsAreScoredOnRequest) {
  const Outcome synth =
      Run({"synth", "--output", In("scene"), "--synth.width", "64", "--synth.height", "48",
           "--synth.views", "3", "--synth.truth_point_count", "2000"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  Write("mask.json",
        R"({"origin": [0, 0, 0], "cell_size": 1000, "dimensions": [1, 1, 1], "voxels": "v.raw"})");
  Write("v.raw", "\1");
  const std::string plane = Write("plane.txt", "0 0 0.001 1");
  const auto evaluate = [this](const std::string& mesh, const std::string& truth,
                               const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "evaluate",       "--mesh", In("scene/" + mesh), "--truth", In("scene/" + truth),
        "--sample_count", "2000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  const std::vector<std::string> both = {
      "--unit", "1",         "--tau",     "0.1",           "--dtu.run",       "--dtu.spacing",
      "0.05",   "--dtu.cap", "1",         "--dtu.mask",    In("mask.json"),   "--dtu.plane",
      plane,    "--scene",   In("scene"), "--strecha.run", "--strecha.sigma", "0.01"};
  const auto json_of = [&](const std::string& mesh, const std::string& truth,
                           std::vector<std::string> more) {
    more.emplace_back("--json");
    const Outcome outcome = Run(evaluate(mesh, truth, more));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const nlohmann::json perfect = json_of("truth.ply", "truth.ply", both);
  EXPECT_EQ(perfect["dtu"]["accuracy"]["mean"].get<double>(), 0);
  EXPECT_EQ(perfect["dtu"]["accuracy"]["count"], perfect["dtu"]["mesh_points"]);
  EXPECT_EQ(perfect["strecha"]["mae"].get<double>(), 0);
  EXPECT_EQ(perfect["strecha"]["covered_share"].get<double>(), 1);
  EXPECT_EQ(perfect["strecha"]["histogram"]["within_sigmas"][0],
            perfect["strecha"]["truth_pixels"]);
  EXPECT_EQ(perfect["strecha"]["views"].size(), 3u);
  const nlohmann::json initial = json_of("init.ply", "truth.ply", both);
  EXPECT_GT(initial["dtu"]["accuracy"]["mean"].get<double>(), 0);
  EXPECT_GT(initial["strecha"]["mae"].get<double>(), 0);

  // Depth maps stand in for the surface that a cloud does not have, and are those of the truth.
  const nlohmann::json by_maps =
      json_of("init.ply", "truth_points.ply",
              {"--strecha.run", "--scene", In("scene"), "--depth", In("scene/depth")});
  EXPECT_NEAR(by_maps["strecha"]["mae"].get<double>(), initial["strecha"]["mae"].get<double>(),
              1e-5);
  EXPECT_TRUE(by_maps["boundary"].is_object());
  EXPECT_FALSE(by_maps.contains("dtu"));

  const Outcome table = Run(evaluate("init.ply", "truth.ply", both));
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("DTU protocol"));
  EXPECT_THAT(table.out, HasSubstr("9 to 10 sigma"));

  ExpectRefused(evaluate("init.ply", "truth_points.ply", {"--strecha.run", "--scene", In("scene")}),
                {"truth_points.ply", "point cloud", "--depth"});
  ExpectRefused(evaluate("init.ply", "truth.ply", {"--strecha.run"}), {"strecha.run", "--scene"});
  ExpectRefused(evaluate("init.ply", "truth.ply", {"--strecha.sigma", "1"}), {"strecha.sigma"});
  ExpectRefused(evaluate("init.ply", "truth.ply", {"--dtu.plane", plane}), {"dtu.plane"});
  ExpectRefused(evaluate("init.ply", "truth.ply", {"--dtu.run", "--dtu.plane", In("none.txt")}),
                {"none.txt", "missing"});
  ExpectRefused(evaluate("init.ply", "truth.ply", {"--align", "affine"}),
                {"--align", "similarity"});
}

// Every way in which a refinement can be asked for in vain, on one small scene.
class RefineErrorsTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    const Outcome synth =
        Run({"synth", "--output", In("scene"), "--text", "--synth.width", "64", "--synth.height",
             "48", "--synth.views", "3", "--synth.truth_point_count", "1000"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
  }

  void ExpectRefineRefused(const std::string& mesh, const std::vector<std::string>& parts) const {
    ExpectRefused({"refine", In("scene"), "--mesh", mesh, "--output", In("out")}, parts);
    EXPECT_FALSE(std::filesystem::exists(In("out")));
  }

  // Rewrites a file of the scene.
  void Replace(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = ReadAll(folder_ / name);
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << name;
    Write(name, text.replace(at, from.size(), to));
  }
};

TEST_F(RefineErrorsTest, Arguments) {
  ExpectRefused({"refine", In("scene"), "--mesh", In("scene/init.ply")}, {"--output", "required"});
  ExpectRefused({"refine", In("nowhere"), "--mesh", In("scene/init.ply"), "--output", In("out")},
                {"nowhere"});
  ExpectRefused({"refine", In("scene"), "--mesh", In("scene/init.ply"), "--output", In("out"),
                 "--solver.type", "newton"},
                {"--solver.type newton: must be one of"});
  ExpectRefused(
      {"refine", In("scene"), "--mesh", In("scene/init.ply"), "--output", In("scene/init.ply")},
      {"init.ply", "Not a directory"});
  EXPECT_FALSE(std::filesystem::exists(In("out")));
}

TEST_F(RefineErrorsTest, Meshes) {
  ExpectRefineRefused(In("none.ply"), {"none.ply"});
  const std::string no_faces = "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n";
  ExpectRefineRefused(Write("points.off", no_faces), {"points.off", "face"});
  ExpectRefineRefused(Write("nan.off", "OFF\n3 1 0\n0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n"),
                      {"nan.off", "vertex 1"});
  ExpectRefineRefused(Write("range.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"),
                      {"range.off", "face 0"});
  ExpectRefineRefused(
      Write("far.off", "OFF\n3 1 0\n900 900 900\n901 900 900\n900 901 900\n3 0 1 2\n"),
      {"far.off"});
}

TEST_F(RefineErrorsTest, InvertedMesh) {
  // A square across the scene, seen from its front and from its back.
  const std::string square = "OFF\n4 2 0\n-0.8 -0.8 0\n0.8 -0.8 0\n0.8 0.8 0\n-0.8 0.8 0\n";
  const std::string inverted = Write("inverted.off", square + "3 0 2 1\n3 0 3 2\n");
  ExpectRefused(
      {"refine", In("scene"), "--mesh", inverted, "--output", In("out"), "--mesh.orient", "off"},
      {"inverted.off", "inside out"});
  const Outcome turned = Run({"refine", In("scene"), "--mesh", inverted, "--output", In("out"),
                              "--level.count", "1", "--level.rounds", "1"});
  EXPECT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_THAT(turned.err, HasSubstr("seen from behind only: their faces are turned"));
  const Outcome outcome =
      Run({"refine", In("scene"), "--mesh", Write("upright.off", square + "3 0 1 2\n3 0 2 3\n"),
           "--output", In("out"), "--level.count", "1", "--level.rounds", "1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(RefineErrorsTest, NoPairsSaysWhichTestFails) {
  const Outcome outcome =
      Run({"refine", In("scene"), "--mesh", In("scene/init.ply"), "--output", In("new/out"),
           "--pairs.method", "sparse_points", "--pairs.min_parallax_deg", "179",
           "--pairs.max_parallax_deg", "180"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("burin: error: no camera pair: view_000.png"));
  EXPECT_THAT(outcome.err, HasSubstr("parallax"));
  EXPECT_FALSE(std::filesystem::exists(In("new"))) << "folders that were made are removed again";
}

TEST_F(RefineErrorsTest, OptionsThatDoNotFitAreRefusedBeforeAnythingIsRead) {
  ExpectRefused({"refine", In("absent"), "--mesh", In("absent.ply"), "--output", In("new"),
                 "--pairs.terms", "XYZ"},
                {"pairs.terms = XYZ"});
  ExpectRefused({"select", In("absent"), "--mesh", In("absent.ply"), "--output", In("new"),
                 "--pairs.method", "file"},
                {"pairs.file: must name a file"});
  EXPECT_FALSE(std::filesystem::exists(In("new")));
}

// burin select needs no photographs; what it writes is what refine --pairs.method file uses.
TEST_F(RefineErrorsTest, SelectedPairsAreRefinedWith) {
  std::filesystem::rename(In("scene/images"), In("images"));
  const Outcome select = Run({"select", In("scene"), "--mesh", In("scene/init.ply"), "--output",
                              In("pairs"), "--pairs.per_camera", "2"});
  EXPECT_EQ(select.exit_code, 0) << select.err;
  for (const char* file : {"graph.png", "coverage.png", "energy_matrix.png", "pair_terms.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(In("pairs") + "/" + file)) << file;
  }
  std::filesystem::rename(In("images"), In("scene/images"));
  const nlohmann::json pairs = nlohmann::json::parse(ReadAll(In("pairs/pairs.json")));
  EXPECT_EQ(pairs["method"], "tuned");
  const Outcome refine = Run({"refine", In("scene"), "--mesh", In("scene/init.ply"), "--output",
                              In("out"), "--pairs.method", "file", "--pairs.file",
                              In("pairs/pairs.json"), "--level.count", "1", "--level.rounds", "1"});
  EXPECT_EQ(refine.exit_code, 0) << refine.err;
  const nlohmann::json summary = nlohmann::json::parse(ReadAll(In("out/summary.json")));
  EXPECT_EQ(summary["pairs"]["method"], "file");
  ASSERT_EQ(summary["pairs"]["list"].size(), pairs["pairs"].size());
  for (size_t k = 0; k < pairs["pairs"].size(); ++k) {
    EXPECT_EQ(summary["pairs"]["list"][k][0], pairs["pairs"][k]["reference"]);
    EXPECT_EQ(summary["pairs"]["list"][k][1], pairs["pairs"][k]["second"]);
  }
}

TEST_F(RefineErrorsTest, Scenes) {
  const std::string init = In("scene/init.ply");
  const std::string cameras = ReadAll(folder_ / "scene/sparse/cameras.txt");
  Replace("scene/sparse/cameras.txt", "PINHOLE 64 48", "FISHEYE 64 48");
  ExpectRefineRefused(init, {"cameras.txt", "FISHEYE"});
  Write("scene/sparse/cameras.txt", cameras);
  Replace("scene/sparse/cameras.txt", "PINHOLE 64 48", "PINHOLE 64 50");
  ExpectRefineRefused(init, {"64 x 48", "64 x 50"});
  Write("scene/sparse/cameras.txt", cameras);

  const auto image = std::filesystem::directory_iterator(folder_ / "scene/images")->path();
  const std::string pixels = ReadAll(image);
  std::ofstream(image, std::ios::binary) << pixels.substr(0, 40);
  ExpectRefineRefused(init, {image.filename().string()});
  std::filesystem::remove(image);
  ExpectRefineRefused(init, {image.filename().string()});
  std::ofstream(image, std::ios::binary) << pixels;

  std::filesystem::remove(folder_ / "scene/sparse/images.txt");
  ExpectRefineRefused(init, {"images.txt"});
}

// A run that fails after its work has begun leaves no folder either.
TEST_F(RefineErrorsTest, FailedRunsLeaveNothing) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--level.border_px", "1000"},
        std::vector<std::string>{"--debug.images", "--pairs.method", "vu",
                                 "--pairs.min_parallax_deg", "170", "--pairs.max_parallax_deg",
                                 "175"},
        std::vector<std::string>{"--solver.type", "bfgs", "--level.max_facet_px", "0.5",
                                 "--motion.type", "free"}}) {
    std::vector<std::string> arguments = {"refine",   In("scene"), "--mesh", In("scene/init.ply"),
                                          "--output", In("out")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(Run(arguments).exit_code, 2) << more[0];
    EXPECT_FALSE(std::filesystem::exists(In("out"))) << more[0];
  }
}

// Names are bytes; reports of them are UTF-8.
TEST_F(RefineErrorsTest, NamesThatAreNotUtf8) {
  const std::string scene = In("caf\xe9");
  std::filesystem::rename(In("scene"), scene);
  const Outcome outcome = Run({"refine", scene, "--mesh", scene + "/init.ply", "--output",
                               In("out"), "--level.count", "1", "--level.rounds", "1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(ReadAll(folder_ / "out/summary.json"));
  EXPECT_THAT(summary["input"]["scene"].get<std::string>(), HasSubstr("caf\xef\xbf\xbd"));
}

// A vertex that no face has takes no part, wherever it is.
TEST_F(RefineErrorsTest, AStrayVertexChangesNothing) {
  const std::string square = "-0.8 -0.8 0\n0.8 -0.8 0\n0.8 0.8 0\n-0.8 0.8 0\n";
  const std::string faces = "3 0 1 2\n3 0 2 3\n";
  std::vector<double> energies;
  for (const char* stray : {"0 0 0", "1e8 -1e9 0"}) {
    const std::string name = "stray" + std::to_string(energies.size());
    const Outcome outcome =
        Run({"refine", In("scene"), "--mesh",
             Write(name + ".off", "OFF\n5 2 0\n" + square + stray + "\n" + faces), "--output",
             In(name), "--level.count", "1", "--level.rounds", "1"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto summary = nlohmann::json::parse(ReadAll(In(name + "/summary.json")));
    energies.push_back(summary["levels"][0]["rounds"][0]["energy_final"]["total"].get<double>());
  }
  EXPECT_NEAR(energies[0], energies[1], 1e-6 * energies[0]);
}

TEST_F(RefineErrorsTest, NothingIsWrongWithTheSceneItself) {
  const Outcome outcome =
      Run({"refine", In("scene"), "--mesh", In("scene/init.ply"), "--output", In("out"),
           "--level.count", "1", "--level.rounds", "1", "--debug.images"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* name :
       {"out/refined.ply", "out/summary.json", "out/trace.csv", "out/debug/level0_view_000.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
  }
  const auto summary = nlohmann::json::parse(ReadAll(folder_ / "out/summary.json"));
  EXPECT_TRUE(summary.is_object());
}

TEST(Documentation, OptionsPageIsUpToDate) {
  EXPECT_EQ(ReadAll(std::filesystem::path(test::kSourceFolder) / "docs/options.md"),
            OptionsDocument())
      << "run: build/release/apps/burin options --markdown > docs/options.md";
}

}  // namespace
}  // namespace burin
