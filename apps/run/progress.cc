#include "apps/run/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <utility>

namespace burin {
namespace {

constexpr double kTerminalPeriodS = 0.1;
constexpr double kLogPeriodS = 10;
// The first evaluations run on cold caches; an estimate from them is worse than none.
constexpr double kEstimateAfterS = 2;
constexpr double kEstimateAfterFraction = 0.02;

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Width of the terminal on standard error; 0 when it is no terminal, or one without carriage return.
int TerminalColumns() {
  const char* terminal = std::getenv("TERM");
  if (isatty(STDERR_FILENO) == 0 || terminal == nullptr || std::string(terminal) == "dumb") {
    return 0;
  }
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

}  // namespace

std::string DurationText(double seconds) {
  const long long whole = std::llround(std::clamp(seconds, 0.0, 1e9));
  char text[48];
  if (whole < 60) {
    std::snprintf(text, sizeof(text), "%llds", whole);
  } else if (whole < 3600) {
    std::snprintf(text, sizeof(text), "%lldm%02llds", whole / 60, whole % 60);
  } else {
    std::snprintf(text, sizeof(text), "%lldh%02lldm", whole / 3600, whole / 60 % 60);
  }
  return text;
}

Progress::Progress() : Progress(&std::cerr, TerminalColumns(), SteadySeconds) {}

Progress::Progress(std::ostream* out, int columns, Clock clock)
    : out_(out), columns_(columns), clock_(std::move(clock)), begin_s_(clock_()) {}

Progress::~Progress() {
  try {
    End();
  } catch (...) {  // a stream that throws must not end the program
    line_shown_ = false;
  }
}

void Progress::Begin(double total_work) {
  EraseLine();
  begin_s_ = clock_();
  // In the first ten seconds only Line() writes to a log; a terminal shows the first Update().
  last_written_s_ = columns_ > 0 ? begin_s_ - kTerminalPeriodS : begin_s_;
  total_work_ = total_work > 0 ? total_work : 1;
}

void Progress::Update(double done_work, const std::string& text) {
  const double now_s = clock_();
  if (now_s - last_written_s_ < (columns_ > 0 ? kTerminalPeriodS : kLogPeriodS)) return;
  last_written_s_ = now_s;
  const double fraction = std::clamp(done_work / total_work_, 0.0, 1.0);
  const double elapsed_s = now_s - begin_s_;
  std::string times = std::to_string(static_cast<int>(100 * fraction)) + "%  " +
                      DurationText(elapsed_s) + " elapsed";
  if (elapsed_s >= kEstimateAfterS && fraction >= kEstimateAfterFraction) {
    times += ", " + DurationText(elapsed_s * (1 - fraction) / fraction) + " left";
  }
  if (columns_ == 0) {
    *out_ << text << "  " << times << std::endl;
    return;
  }
  // What must not be cut off stands in front. The last column stays free, or the terminal would wrap.
  std::string line = times + "  " + text;
  if (static_cast<int>(line.size()) >= columns_) line.resize(std::max(0, columns_ - 1));
  *out_ << '\r' << line << "\x1b[K" << std::flush;
  line_shown_ = true;
}

void Progress::Line(const std::string& text) {
  EraseLine();
  *out_ << text << std::endl;
  if (columns_ == 0) last_written_s_ = clock_();
}

void Progress::End() { EraseLine(); }

double Progress::ElapsedSeconds() const { return clock_() - begin_s_; }

void Progress::EraseLine() {
  if (line_shown_) *out_ << "\r\x1b[K" << std::flush;
  line_shown_ = false;
}

}  // namespace burin
