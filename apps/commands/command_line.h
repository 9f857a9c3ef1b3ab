// From argv to an exit code: the commands of burin, and the one place where errors become messages.
#pragma once

namespace burin {

enum ExitCode {
  kExitOk = 0,
  kExitFailure = 1,   // a fault of burin or of the machine
  kExitBadInput = 2,  // the command line, a file or an option; nothing was half-written
  kExitOutOfMemory = 3,
  kExitCannotBeRight = 4,  // cameras, photographs and mesh do not fit (core/evidence/verdict.h)
  kExitInterrupted = 128,  // + the signal's number: 130 for SIGINT, 143 for SIGTERM
};

// Runs the command named in argv. Every failure is one line on standard error that begins with
// "burin: error: ". Never throws.
int RunCommandLine(int argc, const char* const* argv);

}  // namespace burin
