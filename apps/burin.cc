// The burin program.
#include <glog/logging.h>

#include <cstdio>
#include <cstdlib>

#include "apps/commands/command_line.h"

int main(int argc, char** argv) {
  // Ceres logs through glog. Its warnings are about solver steps that burin reports itself, so only
  // errors reach the terminal, and no log files are written to /tmp.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;
  google::InitGoogleLogging(argv[0]);
  const int code = burin::RunCommandLine(argc, argv);
  if (code == burin::kExitFailure || code == burin::kExitOutOfMemory) {
    // Out of threads or memory, the thread pools of the libraries can wait for ever for themselves
    // in their destructors. Everything of burin's own has been unwound by now.
    std::fflush(nullptr);
    std::_Exit(code);
  }
  return code;
}
