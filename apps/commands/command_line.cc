#include "apps/commands/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "apps/commands/commands.h"
#include "apps/run/memory_limit.h"
#include "apps/run/stop_signals.h"
#include "core/support/did_you_mean.h"
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

// The innermost command on the command line.
const CLI::App* ParsedCommand(const CLI::App* app) {
  while (!app->get_subcommands().empty()) app = app->get_subcommands().front();
  return app;
}

std::vector<std::string> LongFlags(const CLI::App& app) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  return flags;
}

std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = ParsedCommand(&app);
  std::string message = error.what();
  const std::vector<std::string> extras = app.remaining(true);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !extras.empty()) {
    if (extras[0].rfind("--", 0) == 0) {
      const std::string flag = extras[0].substr(0, extras[0].find('='));
      message = flag + ": unknown option" + DidYouMean(flag, LongFlags(*command));
    } else if (command == &app) {
      std::vector<std::string> names;
      for (const CLI::App* known : app.get_subcommands(nullptr)) names.push_back(known->get_name());
      message = extras[0] + ": unknown command" + DidYouMean(extras[0], names);
    } else {
      message = extras[0] + ": unexpected argument";
    }
  }
  const std::string name = command == &app ? "burin" : "burin " + command->get_name();
  return message + "; see " + name + " --help";
}

int ParseAndRun(int argc, const char* const* argv) {
  CLI::App app{"burin: photometric refinement of triangle meshes", "burin"};
  app.set_version_flag("--version", "burin 0.1.0");
  AddRefineCommand(&app);
  AddSelectCommand(&app);
  AddDemoCommand(&app);
  AddCompareCommand(&app);
  AddSynthCommand(&app);
  AddEvaluateCommand(&app);
  AddPictureCommand(&app);
  AddConvertCommand(&app);
  AddSolversCommand(&app);
  AddOptionsCommand(&app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {  // --help, --version, --print-config
    app.exit(done);
    return kExitOk;
  } catch (const CLI::ParseError& error) {
    return Fail(UsageMessage(app, error).c_str(), kExitBadInput);
  }
  if (app.get_subcommands().empty()) {
    return Fail("no command given; see burin --help", kExitBadInput);
  }
  return kExitOk;
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
  } catch (const MemoryLimitError& error) {
    return Fail(error.what(), kExitOutOfMemory);
  } catch (const std::bad_alloc&) {
    return Fail("out of memory", kExitOutOfMemory);
  } catch (const std::exception& error) {
    return Fail(error.what(), kExitFailure);
  }
}

}  // namespace burin
