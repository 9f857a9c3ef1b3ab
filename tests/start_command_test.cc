// burin mesh, as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/mesh/mesh_io.h"
#include "tests/program_test.h"

namespace burin {
namespace {

using StartCommand = ProgramTest;

TEST_F(StartCommand, MakesAMeshOfASyntheticScenesPoints) {
  ASSERT_EQ(Run({"synth", "--output", In("scene"), "--scene", "boulder", "--synth.width", "160",
                 "--synth.views", "12"})
                .exit_code,
            0);
  const Outcome outcome = Run({"mesh", In("scene"), "--output", In("start.ply")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  MeshReport report;
  ReadMesh(In("start.ply"), &report);
  EXPECT_GT(report.face_count, 100);
  EXPECT_EQ(report.nonmanifold_edge_count, 0);
  const nlohmann::json summary = nlohmann::json::parse(ReadAll(In("start.json")));
  EXPECT_EQ(summary["start"]["faces"], report.face_count);
  EXPECT_EQ(summary["options"]["start.points"], "dense");
  // The same bytes again, on one thread.
  ASSERT_EQ(Run({"mesh", In("scene"), "--output", In("again.ply"), "--run.threads", "1"}).exit_code,
            0);
  EXPECT_EQ(ReadAll(In("start.ply")), ReadAll(In("again.ply")));
}

TEST_F(StartCommand, RefineMakesItsOwnMeshWhereNoneIsGiven) {
  ASSERT_EQ(Run({"synth", "--output", In("scene"), "--scene", "relief", "--synth.width", "160"})
                .exit_code,
            0);
  const Outcome outcome = Run({"refine", In("scene"), "--output", In("out")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("no --mesh: making one of the scene itself"));
  EXPECT_TRUE(std::filesystem::exists(In("out/init.ply")));
  EXPECT_TRUE(std::filesystem::exists(In("out/refined.ply")));
  EXPECT_FALSE(std::filesystem::exists(In("out/depths")));
}

TEST_F(StartCommand, RefusesWhatMakesNoMesh) {
  ASSERT_EQ(Run({"synth", "--output", In("scene"), "--scene", "boulder", "--synth.width", "64",
                 "--synth.views", "4", "--synth.point_count", "0"})
                .exit_code,
            0);
  ExpectRefused({"mesh", In("scene"), "--output", In("start.obj")}, {"start.obj", "NAME.ply"});
  ExpectRefused({"mesh", In("scene"), "--output", In("start.ply")}, {"no sparse points"});
  ExpectRefused({"mesh", In("nowhere"), "--output", In("start.ply")}, {"nowhere"});
  EXPECT_FALSE(std::filesystem::exists(In("start.ply")));
}

}  // namespace
}  // namespace burin
