// Runs the program as a process, as a user does, for tests that judge it by exit code, output and the files
// that it leaves.
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/test_paths.h"

namespace burin {

inline std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Outcome {
  int exit_code = -1;  // -1: ended by a signal
  std::string out;
  std::string err;
};

// A folder of its own for each test, removed at the end.
class ProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::path(testing::TempDir()) / "burin cli XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string In(const std::string& name) const { return (folder_ / name).string(); }

  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return In(name);
  }

  Outcome Run(std::vector<std::string> arguments) const {
    return Wait(Start(std::move(arguments)));
  }

  // One at a time: standard output and error go to stdout.txt and stderr.txt in the test's folder.
  pid_t Start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), test::kProgram);
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string out = In("stdout.txt");
    const std::string err = In("stderr.txt");
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    const pid_t child = fork();
    if (child == 0) {
      dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
      dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600), STDOUT_FILENO);
      dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600), STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    return child;
  }

  Outcome Wait(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadAll(In("stdout.txt")),
            ReadAll(In("stderr.txt"))};
  }

  // Bad input: exit code 2 (or the one given), nothing on standard output, one line on standard error
  // that holds each of `parts`.
  void ExpectRefused(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& parts, int exit_code = 2) const {
    const Outcome outcome = Run(arguments);
    const std::string shown = testing::PrintToString(arguments) + "\n" + outcome.err;
    EXPECT_EQ(outcome.exit_code, exit_code) << shown;
    EXPECT_EQ(outcome.out, "") << shown;
    EXPECT_THAT(outcome.err, testing::StartsWith("burin: error: ")) << shown;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << shown;
    for (const std::string& part : parts)
      EXPECT_THAT(outcome.err, testing::HasSubstr(part)) << shown;
  }

  std::filesystem::path folder_;
};

}  // namespace burin
