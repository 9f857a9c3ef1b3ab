// The burin program.
#include <glog/logging.h>

#include "apps/command_line.h"

int main(int argc, char** argv) {
  // Ceres logs through glog. Its warnings are about solver steps that burin reports itself, so only
  // errors reach the terminal, and no log files are written to /tmp.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;
  google::InitGoogleLogging(argv[0]);
  return burin::RunCommandLine(argc, argv);
}
