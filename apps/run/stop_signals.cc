#include "apps/run/stop_signals.h"

#include <csignal>

namespace burin {
namespace {

volatile std::sig_atomic_t caught = 0;

void Note(int signal) {
  caught = signal;
  for (const int again : {SIGINT, SIGTERM}) std::signal(again, SIG_DFL);
}

}  // namespace

StopSignals::StopSignals() {
  caught = 0;
  // A shell's background job has SIGINT ignored: leave it so.
  for (const int signal : {SIGINT, SIGTERM}) {
    if (std::signal(signal, Note) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

StopSignals::~StopSignals() {
  for (const int signal : {SIGINT, SIGTERM}) {
    if (std::signal(signal, SIG_DFL) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

int StopSignals::Caught() const { return caught; }

void StopSignals::ThrowIfCaught() const {
  if (caught != 0) throw Interrupted(caught, "nothing was begun");
}

}  // namespace burin
