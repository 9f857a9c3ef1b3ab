// Every file that fuzzing started from, or found, goes through its reader without a crash, a hang, or an
// exception other than InputError.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/fuzz/targets.h"
#include "tests/test_paths.h"

namespace burin {
namespace {

class FuzzCorpus : public testing::TestWithParam<fuzz::Target> {};

TEST_P(FuzzCorpus, IsReadOrRefused) {
  const std::filesystem::path folder =
      std::filesystem::path(test::kSourceFolder) / "tests/fuzz/corpus" / GetParam().name;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream file(entry.path(), std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    EXPECT_NO_THROW(GetParam().run(bytes.str()));
    ++files;
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(fuzz::Targets()),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace burin
