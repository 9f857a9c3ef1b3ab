#include "apps/run/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace burin {
namespace {

using testing::HasSubstr;
using testing::Not;

class ProgressTest : public testing::Test {
 protected:
  Progress::Clock Clock() {
    return [this] { return now_s_; };
  }
  double now_s_ = 1000;
  std::ostringstream out_;
};

TEST_F(ProgressTest, LogGetsLinesAlwaysAndUpdatesOnlyEveryTenSeconds) {
  Progress progress(&out_, 0, Clock());
  progress.Begin(200);
  for (int i = 0; i < 9; ++i) {
    now_s_ += 1;
    progress.Update(i, "early");
  }
  EXPECT_EQ(out_.str(), "");
  now_s_ += 1;
  progress.Update(50, "level 1/3 energy 2.5");
  EXPECT_EQ(out_.str(), "level 1/3 energy 2.5  25%  10s elapsed, 30s left\n");
  out_.str("");
  now_s_ += 9;
  progress.Line("round 1 done");
  now_s_ += 9;
  progress.Update(60, "too soon after a line");
  EXPECT_EQ(out_.str(), "round 1 done\n");
}

TEST_F(ProgressTest, TerminalLineIsRewrittenWithinItsWidthAndErased) {
  Progress progress(&out_, 30, Clock());
  progress.Begin(1);
  progress.Update(0.5, std::string(100, 'x'));
  const std::string shown = out_.str();
  EXPECT_EQ(shown.substr(0, 1), "\r");
  EXPECT_EQ(shown.find("\x1b[K") - 1, 29U);
  EXPECT_THAT(shown, Not(HasSubstr("\n")));
  EXPECT_THAT(shown, Not(HasSubstr("left"))) << "no estimate from the first moments";
  out_.str("");
  now_s_ += 0.05;
  progress.Update(0.6, "too soon");
  EXPECT_EQ(out_.str(), "");
  progress.Line("kept");
  EXPECT_EQ(out_.str(), "\r\x1b[Kkept\n");
  out_.str("");
  progress.End();
  EXPECT_EQ(out_.str(), "") << "nothing to erase";
}

TEST_F(ProgressTest, EndErasesTheLineThatWasShown) {
  {
    Progress progress(&out_, 40, Clock());
    progress.Begin(1);
    progress.Update(2, "beyond the end");
    EXPECT_THAT(out_.str(), HasSubstr("100%"));
    out_.str("");
  }
  EXPECT_EQ(out_.str(), "\r\x1b[K");
}

TEST(DurationText, PicksTheUnit) {
  EXPECT_EQ(DurationText(0.4), "0s");
  EXPECT_EQ(DurationText(59.4), "59s");
  EXPECT_EQ(DurationText(187), "3m07s");
  EXPECT_EQ(DurationText(7530), "2h05m");
  EXPECT_EQ(DurationText(-1), "0s");
}

}  // namespace
}  // namespace burin
