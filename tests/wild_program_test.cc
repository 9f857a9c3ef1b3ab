// The program on what people really bring: what it says, and its exit code.
#include <nlohmann/json.hpp>

#include "tests/program_test.h"

namespace burin {
namespace {

using testing::HasSubstr;

class Wild : public ProgramTest {};

TEST_F(Wild, AScoreOfNothingIsNoScore) {
  const std::string square = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
  const std::string far =
      "OFF\n4 2 0\n100 100 100\n1100 100 100\n1100 1100 100\n100 1100 100\n3 0 1 2\n3 0 2 3\n";
  const std::vector<std::string> evaluate = {"evaluate",
                                             "--mesh",
                                             Write("metres.off", square),
                                             "--truth",
                                             Write("millimetres.off", far),
                                             "--sample_count",
                                             "1000",
                                             "--unit",
                                             "1",
                                             "--json"};
  const Outcome outcome = Run(evaluate);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("nothing matched"));
  EXPECT_THAT(
      outcome.err,
      HasSubstr("mesh 1 x 1 x 0 around 0.5 0.5 0, truth 1000 x 1000 x 0 around 600 600 100"));
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json["accuracy"]["rmse"].is_null());
  EXPECT_EQ(json["accuracy"]["matched"], 0);
}

}  // namespace
}  // namespace burin
