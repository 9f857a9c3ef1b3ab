// SIGINT and SIGTERM. The work asks whether one has come, so that it ends between two iterations with
// everything on disk.
#pragma once

#include <stdexcept>
#include <string>

namespace burin {

// The command line turns it into one line on standard error and exit code 128 + signal.
class Interrupted : public std::runtime_error {
 public:
  Interrupted(int signal, const std::string& what_now)
      : std::runtime_error("interrupted; " + what_now), signal_(signal) {}
  int signal() const { return signal_; }

 private:
  int signal_;
};

// While one exists the first SIGINT or SIGTERM is noted and the second ends the process at once.
// One at a time; not from several threads.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // The signal that came, 0 = none.
  int Caught() const;
  // For the stages before there is anything to keep.
  void ThrowIfCaught() const;
};

}  // namespace burin
