#include "apps/commands/command_line.h"

#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/run/memory_limit.h"
#include "apps/run/stop_signals.h"
#include "apps/run/verdict_output.h"
#include "core/support/error.h"

namespace burin {
namespace {

int Fail(const char* message, int code) noexcept {
  // Messages may quote what a user typed or a file holds; the promise is one line.
  std::fputs("burin: error: ", stderr);
  for (const char* c = message; *c != '\0'; ++c) {
    std::fputc(static_cast<unsigned char>(*c) < 0x20 || *c == 0x7F ? ' ' : *c, stderr);
  }
  std::fputc('\n', stderr);
  return code;
}

int ParseAndRun(int argc, const char* const* argv) {
  Program program("burin", "0.1.0", "burin: photometric refinement of triangle meshes");
  AddRefineCommand(&program);
  AddMeshCommand(&program);
  AddSelectCommand(&program);
  AddDemoCommand(&program);
  AddCompareCommand(&program);
  AddSynthCommand(&program);
  AddCheckCommand(&program);
  AddEvaluateCommand(&program);
  AddPictureCommand(&program);
  AddConvertCommand(&program);
  AddSolversCommand(&program);
  AddOptionsCommand(&program);
  std::string error;
  return program.Run(argc, argv, &error) ? kExitOk : Fail(error.c_str(), kExitBadInput);
}

}  // namespace

int RunCommandLine(int argc, const char* const* argv) {
  try {
    const int code = ParseAndRun(argc, argv);
    std::cout.flush();
    if (code == kExitOk && !std::cout) {
      return Fail("standard output: cannot be written", kExitBadInput);
    }
    return code;
  } catch (const InputError& error) {
    return Fail(error.what(), kExitBadInput);
  } catch (const Interrupted& interruption) {
    return Fail(interruption.what(), kExitInterrupted + interruption.signal());
  } catch (const CannotBeRight& error) {
    return Fail(error.what(), kExitCannotBeRight);
  } catch (const MemoryLimitError& error) {
    return Fail(error.what(), kExitOutOfMemory);
  } catch (const std::bad_alloc&) {
    return Fail("out of memory", kExitOutOfMemory);
  } catch (const std::exception& error) {
    return Fail(error.what(), kExitFailure);
  }
}

}  // namespace burin
