#include "apps/commands/command.h"

#include <CLI/CLI.hpp>

#include "apps/commands/option_binding.h"
#include "core/support/did_you_mean.h"

namespace burin {
namespace {

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
  const std::string name =
      command == &app ? app.get_name() : app.get_name() + " " + command->get_name();
  return message + "; see " + name + " --help";
}

}  // namespace

Argument& Argument::Required() {
  option_->required();
  return *this;
}

Argument& Argument::Positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}

Argument& Argument::Excludes(const Argument& other) {
  option_->excludes(other.option_);
  return *this;
}

bool Argument::Given() const { return !option_->empty(); }

void Argument::ThrowMissing() const { throw CLI::RequiredError(option_->get_name()); }

Argument Command::Text(const std::string& name, const std::string& placeholder, std::string* value,
                       const std::string& help) {
  return Argument(app_->add_option(name, *value, help)->option_text(placeholder));
}

Argument Command::Number(const std::string& name, double* value, const std::string& help) {
  return Argument(app_->add_option(name, *value, help));
}

Argument Command::Flag(const std::string& name, bool* value, const std::string& help) {
  return Argument(app_->add_flag(name, *value, help));
}

std::vector<Argument> Command::Scene(SceneArguments* source, bool photographs) {
  std::vector<Argument> arguments;
  for (CLI::Option* option : BindScene(source, app_, photographs)) arguments.emplace_back(option);
  return arguments;
}

void Command::Options(OptionSet* set, const std::map<std::string, std::string>& short_flags,
                      const std::function<void()>& check) {
  BindOptions(set, app_, short_flags, check);
}

void Command::OnRun(const std::function<void()>& run) { app_->callback(run); }

std::vector<std::string> Command::Given() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : app_->get_options()) {
    if (option->count() > 0) names.push_back(option->get_name());
  }
  return names;
}

bool Command::Given(const std::string& name) const { return app_->count(name) > 0; }

Program::Program(const std::string& name, const std::string& version, const std::string& help)
    : app_(std::make_unique<CLI::App>(help, name)) {
  app_->set_version_flag("--version", name + " " + version);
}

Program::~Program() = default;

Command Program::Add(const std::string& name, const std::string& help) {
  return Command(app_->add_subcommand(name, help));
}

bool Program::Run(int argc, const char* const* argv, std::string* error) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& done) {  // --help, --version, --print-config
    app_->exit(done);
    return true;
  } catch (const CLI::ParseError& fault) {
    *error = UsageMessage(*app_, fault);
    return false;
  }
  if (!app_->get_subcommands().empty()) return true;
  *error = "no command given; see " + app_->get_name() + " --help";
  return false;
}

std::string Program::Version() const { return app_->version(); }

std::string Program::Help() const { return app_->get_description(); }

std::vector<CommandHelp> Program::Commands() const {
  std::vector<CommandHelp> commands;
  const CLI::App& program = *app_;
  for (const CLI::App* command : program.get_subcommands(nullptr)) {
    CommandHelp help{{command->get_name(), command->get_description()}, {}};
    for (const CLI::Option* option : command->get_options()) {
      help.arguments.push_back({option->get_name(), option->get_description()});
    }
    commands.push_back(help);
  }
  return commands;
}

}  // namespace burin
