// Runs that are interrupted, killed and resumed, as processes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "apps/run/checkpoint.h"
#include "tests/program_test.h"

namespace burin {
namespace {

using testing::HasSubstr;

class ResumeTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const Outcome synth =
        Run({"synth", "--output", In("scene"), "--synth.width", "160", "--synth.height", "120",
             "--synth.views", "4", "--synth.truth_point_count", "1000"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
  }
  std::vector<std::string> Refine(const std::string& output) const {
    return {"refine",   In("scene"),           "--mesh", In("scene/init.ply"),      "--output",
            In(output), "--level.min_side_px", "30",     "--solver.max_iterations", "6"};
  }
  std::vector<std::string> Resume(const std::string& output) const {
    return {"refine", "--resume", In(output)};
  }
  std::string Mesh(const std::string& output) const { return ReadAll(In(output + "/refined.ply")); }
  std::set<std::string> Files(const std::string& output) const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(In(output))) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  // Lines of finished rounds on the standard error of the run under way.
  int RoundsTold() const {
    const std::string err = ReadAll(In("stderr.txt"));
    int rounds = 0;
    for (size_t at = 0; (at = err.find("pixel pairs", at)) != std::string::npos; ++at) ++rounds;
    return rounds;
  }
  // -1 when there is no checkpoint.
  int RoundsSaved(const std::string& output) const {
    const std::filesystem::path path = CheckpointPath(In(output));
    if (!std::filesystem::exists(path)) return -1;
    const Checkpoint checkpoint = ReadCheckpoint(path);
    int rounds = 0;
    if (checkpoint.state.has_value()) {
      for (const LevelSummary& level : checkpoint.state->summary.levels) {
        rounds += static_cast<int>(level.rounds.size());
      }
    }
    return rounds;
  }
  void WaitForRounds(int rounds) const {
    while (RoundsTold() < rounds) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
};

TEST_F(ResumeTest, SignalsLeaveAMeshAndARunThatGoesOnToTheSameBytes) {
  const Outcome whole = Run(Refine("whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const std::set<std::string> complete = {"refined.ply", "summary.json", "trace.csv",
                                          "config.toml", "cameras",      "whole.ply"};
  EXPECT_EQ(Files("whole"), complete);
  struct Case {
    int signal;
    int rounds;
  };
  for (const Case& c : {Case{SIGINT, 1}, Case{SIGTERM, 7}}) {
    SCOPED_TRACE(c.signal);
    const std::string name = "stopped" + std::to_string(c.signal);
    const pid_t child = Start(Refine(name));
    WaitForRounds(c.rounds);
    kill(child, c.signal);
    const Outcome stopped = Wait(child);
    EXPECT_EQ(stopped.exit_code, 128 + c.signal);
    EXPECT_THAT(stopped.err, HasSubstr("burin refine --resume"));
    std::set<std::string> kept = complete;
    kept.insert("checkpoint.cbor");
    EXPECT_EQ(Files(name), kept);
    EXPECT_NE(Mesh(name), Mesh("whole"));
    // What refined.ply holds was judged, and log and summary say how.
    EXPECT_THAT(stopped.err, HasSubstr(" cut short in round "));
    EXPECT_THAT(stopped.err, HasSubstr("kept: photographs held back do not agree less"));
    const auto part = nlohmann::json::parse(ReadAll(In(name + "/summary.json")));
    EXPECT_EQ(part["complete"], false);
    for (const auto& level : part["levels"]) {
      EXPECT_EQ(level["interrupted"], level == part["levels"].back());
      EXPECT_EQ(level["undone"], false);
      EXPECT_GT(level["held_back"]["windows"], 0);
    }
    const int saved = RoundsSaved(name);
    EXPECT_GE(saved, c.rounds - 1);
    const Outcome resumed = Run(Resume(name));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_EQ(Mesh(name), Mesh("whole"));
    EXPECT_EQ(ReadAll(In(name + "/config.toml")), ReadAll(In("whole/config.toml")));
    EXPECT_EQ(Files(name), complete);
    const auto summary = nlohmann::json::parse(ReadAll(In(name + "/summary.json")));
    const auto reference = nlohmann::json::parse(ReadAll(In("whole/summary.json")));
    for (const char* key :
         {"complete", "iterations", "evaluations", "output", "pairs", "options"}) {
      EXPECT_EQ(summary[key], reference[key]) << key;
    }
    const auto lines = [this](const std::string& run) {
      const std::string trace = ReadAll(In(run + "/trace.csv"));
      return std::count(trace.begin(), trace.end(), '\n');
    };
    EXPECT_EQ(lines(name), lines("whole"));
  }
  const Outcome again = Run(Resume("whole"));
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.out, HasSubstr("the run is complete"));
}

// kill -9 at twenty random moments: some time after a run or a resumed run has told of none, one or two
// rounds, whatever the machine's speed. Runs that get to their end in between begin anew.
TEST_F(ResumeTest, KilledTwentyTimesItLosesAtMostTheRoundInWork) {
  ASSERT_EQ(Run(Refine("whole")).exit_code, 0);
  const auto complete = [this] {
    return !std::filesystem::exists(CheckpointPath(In("killed"))) &&
           std::filesystem::exists(In("killed/summary.json"));
  };
  std::mt19937 random(5);
  std::uniform_int_distribution<int> rounds(0, 2);
  std::uniform_int_distribution<int> later_ms(0, 40);
  int saved = -1;  // rounds in the checkpoint, -1 when there is none
  int kills_that_advanced = 0;
  for (int k = 0; k < 20; ++k) {
    const pid_t child = Start(saved < 0 ? Refine("killed") : Resume("killed"));
    const int wanted = rounds(random);
    while (RoundsTold() < wanted && !complete()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(later_ms(random)));
    kill(child, SIGKILL);
    Wait(child);
    if (complete()) {
      EXPECT_EQ(Mesh("killed"), Mesh("whole"));
      std::filesystem::remove_all(In("killed"));
      saved = -1;
      continue;
    }
    const int now = RoundsSaved("killed");
    EXPECT_GE(now, std::max(0, saved) + RoundsTold() - 1);
    EXPECT_GE(now, saved);
    if (now > std::max(0, saved)) ++kills_that_advanced;
    saved = now;
  }
  EXPECT_GE(kills_that_advanced, 5);
  const Outcome last = Run(saved < 0 ? Refine("killed") : Resume("killed"));
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(Mesh("killed"), Mesh("whole"));
  EXPECT_EQ(Files("killed"), Files("whole"));
}

// What the run was given holds from any folder, and its own number of threads.
TEST_F(ResumeTest, GoesOnFromAnyFolderWithTheSameSettings) {
  ASSERT_EQ(Run({"select", In("scene"), "--mesh", In("scene/init.ply"), "--output", In("pairs"),
                 "--no-pictures"})
                .exit_code,
            0);
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::current_path(In("."));
  std::vector<std::string> arguments = Refine("run");
  for (const char* more :
       {"--pairs.method", "file", "--pairs.file", "pairs/pairs.json", "--run.threads", "1"}) {
    arguments.emplace_back(more);
  }
  const pid_t child = Start(arguments);
  WaitForRounds(1);
  kill(child, SIGINT);
  Wait(child);
  std::filesystem::current_path(here);
  const Outcome resumed = Run(Resume("run"));
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  const auto summary = nlohmann::json::parse(ReadAll(In("run/summary.json")));
  EXPECT_EQ(summary["options"]["run.threads"], 1);
  EXPECT_EQ(summary["options"]["pairs.file"], In("pairs/pairs.json"));
}

// As on a machine with less memory free and another instruction set than the one that the run began on.
TEST_F(ResumeTest, GoesOnOnAnotherMachine) {
  ASSERT_EQ(Run(Refine("whole")).exit_code, 0);
  std::vector<std::string> arguments = Refine("run");
  arguments.insert(arguments.end(), {"--memory.limit_gb", "8"});
  const pid_t child = Start(arguments);
  WaitForRounds(1);
  kill(child, SIGINT);
  Wait(child);
  Checkpoint checkpoint = ReadCheckpoint(CheckpointPath(In("run")));
  ASSERT_TRUE(checkpoint.state.has_value());
  checkpoint.instruction_set = "ABACUS";
  WriteCheckpoint(CheckpointPath(In("run")), checkpoint);
  arguments = Resume("run");
  arguments.insert(arguments.end(), {"--run.threads", "1", "--memory.limit_gb"});
  arguments.emplace_back("0.001");
  const Outcome refused = Run(arguments);
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("memory.limit_gb"));
  arguments.back() = "16";
  const Outcome resumed = Run(arguments);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.err, HasSubstr("the run so far used ABACUS, this machine has "));
  EXPECT_EQ(Mesh("run"), Mesh("whole"));
  const auto summary = nlohmann::json::parse(ReadAll(In("run/summary.json")));
  EXPECT_EQ(summary["options"]["memory.limit_gb"], 16);
  EXPECT_EQ(summary["options"]["run.threads"], 1);
  EXPECT_NE(summary["instruction_set"], "ABACUS");
}

// Neither by a second run nor by itself does a run lose what it needs to go on.
TEST_F(ResumeTest, TheFolderAndTheMeshOfARunAreItsOwn) {
  const pid_t child = Start(Refine("run"));
  WaitForRounds(1);
  kill(child, SIGSTOP);
  // Not with Run, which would take the first one's output.
  const std::string command = "'" + std::string(test::kProgram) + "' refine '" + In("scene") +
                              "' --mesh '" + In("scene/init.ply") + "' --output '" + In("run") +
                              "' 2>'" + In("second.txt") + "'";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_THAT(ReadAll(In("second.txt")), HasSubstr("run: another run of burin writes to this"));
  kill(child, SIGCONT);
  EXPECT_EQ(Wait(child).exit_code, 0);
  std::vector<std::string> again = Refine("run");
  again[3] = In("run/refined.ply");
  const std::string mesh = Mesh("run");
  ExpectRefused(again, {"--mesh: this run would write to", "refined.ply"});
  EXPECT_EQ(Mesh("run"), mesh);
}

TEST_F(ResumeTest, ARunThatWasMovedGoesOn) {
  const Outcome whole = Run(Refine("whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const pid_t child = Start(Refine("run"));
  WaitForRounds(1);
  kill(child, SIGTERM);
  EXPECT_EQ(Wait(child).exit_code, 143);
  // Together with its inputs, and then without its mesh.
  std::filesystem::create_directories(In("elsewhere"));
  std::filesystem::copy(In("run"), In("elsewhere/run"), std::filesystem::copy_options::recursive);
  std::filesystem::rename(In("scene"), In("elsewhere/scene"));
  std::filesystem::copy(In("elsewhere/run"), In("elsewhere/again"),
                        std::filesystem::copy_options::recursive);
  const Outcome moved = Run(Resume("elsewhere/run"));
  ASSERT_EQ(moved.exit_code, 0) << moved.err;
  EXPECT_EQ(Mesh("elsewhere/run"), Mesh("whole"));
  std::filesystem::rename(In("elsewhere/scene/init.ply"), In("start.ply"));
  ExpectRefused(Resume("elsewhere/again"), {"init.ply"});
  std::vector<std::string> named = Resume("elsewhere/again");
  named.insert(named.end(), {"--mesh", In("start.ply")});
  const Outcome told = Run(named);
  ASSERT_EQ(told.exit_code, 0) << told.err;
  EXPECT_EQ(Mesh("elsewhere/again"), Mesh("whole"));
}

TEST_F(ResumeTest, WhatCannotBeResumedIsRefused) {
  ExpectRefused(Resume("none"), {"none/checkpoint.cbor: file is missing"});
  std::vector<std::string> arguments = Resume("none");
  arguments.insert(arguments.end(), {"--output", In("other")});
  ExpectRefused(arguments, {"--resume", "excludes"});
  const pid_t child = Start(Refine("run"));
  WaitForRounds(1);
  kill(child, SIGTERM);
  EXPECT_EQ(Wait(child).exit_code, 143);
  // Other options, with their default value too, and files of options.
  const std::string config = Write("options.toml", "[run]\nthreads = 1\n");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--photo.window", "7"},
        std::vector<std::string>{"--smooth.weight", "60", "--run.threads", "2"},
        std::vector<std::string>{"--config", config}}) {
    arguments = Resume("run");
    arguments.insert(arguments.end(), more.begin(), more.end());
    ExpectRefused(arguments, {"only --run.threads and --memory.limit_gb may be given"});
  }
  ExpectRefused({"refine", "--resume", ""}, {"--resume: must name a folder"});
  const std::string whole = ReadAll(In("run/checkpoint.cbor"));
  std::filesystem::rename(In("scene/init.ply"), In("init.ply"));
  std::filesystem::copy_file(In("scene/truth.ply"), In("scene/init.ply"));
  ExpectRefused(Resume("run"), {"is not what it was when the run began"});
  for (const size_t size : {size_t{0}, size_t{40}, whole.size() / 2, whole.size() - 1}) {
    Write("run/checkpoint.cbor", whole.substr(0, size));
    ExpectRefused(Resume("run"), {"run/checkpoint.cbor", "is not a checkpoint"});
  }
  for (const size_t at : {size_t{3}, whole.size() / 3, 2 * whole.size() / 3}) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x15);
    Write("run/checkpoint.cbor", broken);
    ExpectRefused(Resume("run"), {"run/checkpoint.cbor"});
  }
  std::string older = whole;
  const std::string key = "burin_checkpoint";
  older.at(older.find(key) + key.size()) -= 1;  // the version, a CBOR number below 24
  Write("run/checkpoint.cbor", older);
  ExpectRefused(Resume("run"), {"run/checkpoint.cbor: version is ", ": written by another burin"});
}

}  // namespace
}  // namespace burin
