// How a command tells its arguments, its options and what it does, and the program that parses them.
// CLI11 does the work behind this header: it takes longer to compile than any command, so only
// command.cc and option_binding.cc include it.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "apps/run/scene_arguments.h"
#include "core/support/options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace burin {

// One argument of a command. A handle: copies are the same argument.
class Argument {
 public:
  explicit Argument(CLI::Option* option) : option_(option) {}
  Argument& Required();                       // a command line without it is refused
  Argument& Positive();                       // its number must be greater than zero
  Argument& Excludes(const Argument& other);  // a command line with both is refused
  bool Given() const;                         // on the command line; after parsing
  [[noreturn]] void ThrowMissing() const;     // the error that Required() leads to

 private:
  CLI::Option* option_;
};

// One command. A handle, too. What it is given pointers to is written while the command line is parsed
// and must live until then.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}
  // `name` is "--mesh" or, for an argument by position, "scene". `placeholder` stands after it in the
  // help.
  Argument Text(const std::string& name, const std::string& placeholder, std::string* value,
                const std::string& help);
  Argument Number(const std::string& name, double* value, const std::string& help);
  Argument Flag(const std::string& name, bool* value, const std::string& help);
  // BindScene and BindOptions (apps/commands/option_binding.h).
  std::vector<Argument> Scene(SceneArguments* source, bool photographs);
  void Options(OptionSet* set, const std::map<std::string, std::string>& short_flags = {},
               const std::function<void()>& check = {});
  // What the command does once its command line has been parsed.
  void OnRun(const std::function<void()>& run);
  // What is on the command line, after parsing: all names, and whether one of them is.
  std::vector<std::string> Given() const;
  bool Given(const std::string& name) const;

 private:
  CLI::App* app_;
};

// Name and help of a command and of its arguments.
struct CommandHelp {
  struct Line {
    std::string name;
    std::string help;
  };
  Line command;
  std::vector<Line> arguments;
};

class Program {
 public:
  Program(const std::string& name, const std::string& version, const std::string& help);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  Command Add(const std::string& name, const std::string& help);
  // Parses the command line and runs its command, or prints help, version or config. False with one
  // line in *error when the command line is wrong. What the command throws goes through.
  bool Run(int argc, const char* const* argv, std::string* error);

  std::string Version() const;
  std::string Help() const;  // one line
  std::vector<CommandHelp> Commands() const;

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace burin
