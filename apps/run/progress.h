// What a person sees while burin works. On a terminal it is one line that is rewritten, in a log plain
// lines, few enough to read. Both give the elapsed time and an estimate of the time that remains.
#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace burin {

class Progress {
 public:
  using Clock = std::function<double()>;  // seconds since any fixed moment, never decreasing

  // Writes to standard error, as a terminal when it is one.
  Progress();
  // For tests and other streams. `columns` is the width of the rewritten line; 0 = not a terminal.
  // The stream must outlive the object.
  Progress(std::ostream* out, int columns, Clock clock);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Starts the clock. `total_work` > 0 is in any unit that costs about the same time everywhere,
  // such as pixels times pairs times evaluations; 1 makes Update() take a fraction.
  void Begin(double total_work);

  // The work done so far, in [0, total_work] (clamped), and what is going on, e.g.
  // "level 2/3 round 1/2 iteration 7 energy 41234.5". Cheap to call often: shown at most ten times
  // a second on a terminal, and in a log when neither Update() nor Line() wrote for ten seconds.
  void Update(double done_work, const std::string& text);

  // A line that stays: the result of a round, a warning. Always written.
  void Line(const std::string& text);

  // Removes the rewritten line. Also done by the destructor, so an error message starts on a line
  // of its own.
  void End();

  double ElapsedSeconds() const;  // since Begin()

 private:
  void EraseLine();

  std::ostream* out_;
  int columns_;
  Clock clock_;
  double begin_s_ = 0;
  double total_work_ = 1;
  double last_written_s_ = 0;
  bool line_shown_ = false;
};

// "42s", "3m07s", "2h05m".
std::string DurationText(double seconds);

}  // namespace burin
