// burin compare-solvers as a process, on a tiny scene with known truth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "core/solve/solver_strategy.h"
#include "tests/program_test.h"

namespace burin {
namespace {

using testing::HasSubstr;

struct CsvRow {
  std::string mode, strategy, level, round, width, height, faces, unknowns, cameras, pairs,
      iteration, evaluations, seconds, energy, rmse, camera_px, accepted, note;
};

std::vector<CsvRow> ReadCsv(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "mode,strategy,level,round,width,height,faces,unknowns,cameras,pairs,iteration,"
            "evaluations,seconds,energy,rmse,camera_px,accepted,note");
  std::vector<CsvRow> rows;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    CsvRow row;
    for (std::string* field :
         {&row.mode, &row.strategy, &row.level, &row.round, &row.width, &row.height, &row.faces,
          &row.unknowns, &row.cameras, &row.pairs, &row.iteration, &row.evaluations, &row.seconds,
          &row.energy, &row.rmse, &row.camera_px, &row.accepted}) {
      std::getline(fields, *field, ',');
    }
    std::getline(fields, row.note);
    rows.push_back(row);
  }
  return rows;
}

double Number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  EXPECT_TRUE(!text.empty() && *end == '\0') << "not a number: '" << text << "'";
  return value;
}

class CompareTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const Outcome synth =
        Run({"synth", "--output", In("scene"), "--synth.width", "96", "--synth.height", "72",
             "--synth.views", "4", "--synth.truth_point_count", "1000"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
  }

  // The command with short rounds, so that every strategy is quick.
  std::vector<std::string> Command(const std::vector<std::string>& more,
                                   const std::string& iterations = "4") const {
    std::vector<std::string> arguments = {"compare-solvers",
                                          In("scene"),
                                          "--mesh",
                                          In("scene/init.ply"),
                                          "--output",
                                          In("out"),
                                          "--level.rounds",
                                          "1",
                                          "--level.extra_rounds",
                                          "0",
                                          "--level.min_side_px",
                                          "1",
                                          "--solver.max_iterations",
                                          iterations,
                                          "--sample_count",
                                          "2000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(CompareTest, FrozenRoundsAreTheSameForEveryStrategy) {
  const Outcome outcome = Run(Command({"--truth", In("scene/truth.ply"), "--level.count", "2"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const Strategy& strategy : Strategies()) {
    EXPECT_THAT("\n" + outcome.out, HasSubstr("\n" + strategy.name + " "));
  }
  using Round = std::pair<std::string, std::string>;
  std::map<Round, std::set<std::string>> strategies;
  std::map<Round, CsvRow> start;
  std::map<std::tuple<std::string, std::string, std::string>, CsvRow> last;
  for (const CsvRow& row : ReadCsv(ReadAll(In("out/compare.csv")))) {
    ASSERT_EQ(row.note, "") << row.strategy;
    EXPECT_EQ(row.mode, "frozen");
    const Round round(row.level, row.round);
    const auto key = std::make_tuple(row.strategy, row.level, row.round);
    EXPECT_GE(Number(row.rmse), 0);
    if (strategies[round].insert(row.strategy).second) {
      // The first row of a strategy: the start, which is evaluated by each anew.
      EXPECT_EQ(row.iteration, "0");
      EXPECT_GE(Number(row.evaluations), 1) << row.strategy;
      const CsvRow& first = start.emplace(round, row).first->second;
      EXPECT_NEAR(Number(row.energy), Number(first.energy), 1e-6 * Number(first.energy))
          << row.strategy;
      EXPECT_EQ(row.rmse, first.rmse) << row.strategy;
    } else {
      const CsvRow& before = last.at(key);
      EXPECT_GE(Number(row.seconds), Number(before.seconds)) << row.strategy;
      EXPECT_GE(Number(row.evaluations), Number(before.evaluations)) << row.strategy;
      EXPECT_GE(Number(row.iteration), Number(before.iteration)) << row.strategy;
      if (row.accepted == "0") {
        EXPECT_EQ(row.energy, before.energy) << row.strategy;
        EXPECT_EQ(row.rmse, before.rmse) << row.strategy;
      }
    }
    last[key] = row;
  }
  EXPECT_EQ(strategies.size(), 2u) << "levels";
  for (const auto& [round, names] : strategies) EXPECT_EQ(names.size(), Strategies().size());

  const nlohmann::json json = nlohmann::json::parse(ReadAll(In("out/compare.json")));
  EXPECT_EQ(json["mode"], "frozen");
  EXPECT_EQ(json["options"]["solver.max_iterations"], 4);
  EXPECT_TRUE(json["versions"].contains("ceres"));
  ASSERT_EQ(json["strategies"].size(), Strategies().size());
  double best_share = 0;
  for (const nlohmann::json& entry : json["strategies"]) {
    const std::string name = entry["strategy"];
    EXPECT_EQ(entry["status"], "ok") << name << entry["reason"];
    EXPECT_LT(entry["energy_final"], entry["energy_initial"]) << name;
    best_share = std::max(best_share, entry["reduction_share"].get<double>());
    EXPECT_LE(entry["reduction_share"], 1 + 1e-9) << name;
    ASSERT_EQ(entry["rounds"].size(), 2u) << name;
    for (const nlohmann::json& round : entry["rounds"]) {
      const CsvRow& row = last.at({name, std::to_string(round["level"].get<int>()),
                                   std::to_string(round["round"].get<int>())});
      EXPECT_GE(round["evaluations"], Number(row.evaluations)) << name;
      const double energy = round["energy_final"]["total"];
      EXPECT_NEAR(energy, Number(row.energy), 1e-6 * energy) << name;
      EXPECT_EQ(round["image"], nlohmann::json({Number(row.width), Number(row.height)})) << name;
      EXPECT_EQ(round["faces"], Number(row.faces)) << name;
      EXPECT_EQ(round["unknowns"], Number(row.unknowns)) << name;
      EXPECT_EQ(json["pairs"]["count"], Number(row.pairs)) << name;
      const double rmse = round["rmse_final"];
      EXPECT_NEAR(rmse, Number(row.rmse), 1e-9) << name << ": the last row is what it returned";
    }
    EXPECT_GT(entry["evaluation"]["scores"].size(), 0u) << name;
  }
  EXPECT_GT(best_share, 0.9);
  EXPECT_THAT(outcome.out, HasSubstr("\nto draw them, in burin's source folder: ./run charts " +
                                     In("out") + "\n"));
}

TEST_F(CompareTest, EveryStrategyHasARoundWithCamerasAsUnknowns) {
  std::vector<std::string> arguments =
      Command({"--truth", In("scene/truth.ply"), "--level.count", "2", "--cameras.refine", "poses",
               "--cameras.steps", "joint"});
  // The last round of a level moves the surface alone.
  *(std::find(arguments.begin(), arguments.end(), "--level.rounds") + 1) = "2";
  const Outcome outcome = Run(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("round 1, with 4 cameras as unknowns\n"));
  EXPECT_THAT(outcome.err, HasSubstr("cameras moved by"));
  std::map<std::string, CsvRow> last;
  int others = 0;
  for (const CsvRow& row : ReadCsv(ReadAll(In("out/compare.csv")))) {
    if (row.cameras == "0") {
      EXPECT_EQ(row.camera_px, "");
      ++others;
      continue;
    }
    EXPECT_EQ(row.cameras, "4");
    EXPECT_EQ(row.level + " " + row.round, "1 0");
    if (row.iteration == "0") {
      EXPECT_LT(Number(row.camera_px), 1e-6) << row.strategy;
    }
    last[row.strategy] = row;
  }
  EXPECT_GT(others, 0);
  const nlohmann::json json = nlohmann::json::parse(ReadAll(In("out/compare.json")));
  for (const nlohmann::json& entry : json["strategies"]) {
    const std::string name = entry["strategy"];
    const nlohmann::json& round = entry["rounds"][0];
    EXPECT_EQ(round["cameras"], 4) << name;
    EXPECT_GT(round["camera_px"], 0.001) << name;
    EXPECT_NEAR(Number(last.at(name).camera_px), round["camera_px"], 1e-9) << name;
    EXPECT_FALSE(entry["rounds"][1].contains("camera_px"));
  }
  EXPECT_EQ(last.size(), Strategies().size());
}

TEST_F(CompareTest, RefusedStrategiesAreRowsAndDoNotStopTheOthers) {
  // More than the 8000 unknowns that bfgs takes.
  std::vector<std::string> arguments =
      Command({"--level.count", "1", "--level.max_facet_px", "0.5", "--motion.type", "free",
               "--solvers", "lm_cgnr,bfgs"},
              "1");
  const Outcome outcome = Run(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("refused: solver.type = bfgs"));
  std::set<std::string> noted;
  std::set<std::string> solved;
  for (const CsvRow& row : ReadCsv(ReadAll(In("out/compare.csv")))) {
    (row.note.empty() ? solved : noted).insert(row.strategy);
    if (!row.note.empty()) {
      EXPECT_THAT(row.note, HasSubstr("8000"));
      EXPECT_EQ(row.energy, "");
      EXPECT_GT(Number(row.unknowns), 8000);
    }
    EXPECT_EQ(row.rmse, "") << "there is no truth";
  }
  EXPECT_EQ(noted, std::set<std::string>{"bfgs"});
  EXPECT_EQ(solved, std::set<std::string>{"lm_cgnr"});
  const nlohmann::json json = nlohmann::json::parse(ReadAll(In("out/compare.json")));
  EXPECT_EQ(json["strategies"][0]["status"], "refused");
  EXPECT_TRUE(json["strategies"][0]["energy_final"].is_null());

  std::filesystem::remove_all(In("out"));
  arguments.back() = "bfgs";
  const Outcome nothing = Run(arguments);
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_THAT(nothing.err, HasSubstr("burin: error: no strategy ran; bfgs: refused: "));
  EXPECT_FALSE(std::filesystem::exists(In("out")));
}

// Mode whole is what a user gets from burin refine with each strategy.
TEST_F(CompareTest, WholeRunsAreThoseOfRefine) {
  const std::vector<std::string> names = {"steepest_descent", "lm_cgnr"};
  const Outcome outcome =
      Run(Command({"--truth", In("scene/truth.ply"), "--compare.mode", "whole", "--compare.error",
                   "round", "--solvers", "lm_cgnr,steepest_descent", "--level.count", "2"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, CsvRow> last;
  for (const CsvRow& row : ReadCsv(ReadAll(In("out/compare.csv")))) {
    EXPECT_EQ(row.mode, "whole");
    EXPECT_GT(Number(row.faces), 0) << row.strategy;
    if (last.count(row.strategy) > 0) {
      EXPECT_GE(Number(row.seconds), Number(last[row.strategy].seconds));
      EXPECT_GE(Number(row.evaluations), Number(last[row.strategy].evaluations));
    }
    last[row.strategy] = row;
  }
  const nlohmann::json json = nlohmann::json::parse(ReadAll(In("out/compare.json")));
  for (size_t k = 0; k < names.size(); ++k) {
    const nlohmann::json& entry = json["strategies"][k];
    ASSERT_EQ(entry["strategy"], names[k]);
    const Outcome refine = Run({"refine",
                                In("scene"),
                                "--mesh",
                                In("scene/init.ply"),
                                "--output",
                                In(names[k]),
                                "--level.rounds",
                                "1",
                                "--level.extra_rounds",
                                "0",
                                "--level.min_side_px",
                                "1",
                                "--solver.max_iterations",
                                "4",
                                "--level.count",
                                "2",
                                "--surface.remesh",
                                "none",
                                "--surface.trim",
                                "none",
                                "--solver.type",
                                names[k]});
    ASSERT_EQ(refine.exit_code, 0) << refine.err;
    const nlohmann::json summary = nlohmann::json::parse(ReadAll(In(names[k] + "/summary.json")));
    const double energy = entry["energy_final"];
    EXPECT_NEAR(summary["levels"].back()["rounds"].back()["energy_final"]["total"].get<double>(),
                energy, 1e-9 * energy)
        << names[k];
    EXPECT_EQ(entry["iterations"], summary["iterations"]);
    const Outcome score = Run({"evaluate", "--mesh", In(names[k] + "/refined.ply"), "--truth",
                               In("scene/truth.ply"), "--sample_count", "2000", "--json"});
    const double rmse = nlohmann::json::parse(score.out)["accuracy"]["rmse"];
    EXPECT_NEAR(entry["rmse_final"].get<double>(), rmse, 1e-5 * rmse) << names[k];
    EXPECT_NEAR(Number(last[names[k]].rmse), rmse, 1e-5 * rmse) << names[k];
  }
}

TEST_F(CompareTest, BadInputIsOneLine) {
  ExpectRefused(Command({"--solvers", "lm_cgnr,lbgfs"}),
                {"'lbgfs' is not a strategy (did you mean lbfgs?)"});
  ExpectRefused(Command({"--solvers", ","}), {"compare.solvers"});
  ExpectRefused(Command({"--compare.mode", "both"}), {"--compare.mode both: must be one of"});
  ExpectRefused(Command({"--truth", In("none.ply")}), {"none.ply"});
  ExpectRefused(Command({"--tau", "5,x"}), {"tau"});
  ExpectRefused({"compare-solvers", In("scene"), "--output", In("out")}, {"--mesh", "required"});
  ExpectRefused(Command({"--memory.limit_gb", "0.001"}), {"memory.limit_gb"}, 3);
  EXPECT_FALSE(std::filesystem::exists(In("out")));
}

}  // namespace
}  // namespace burin
