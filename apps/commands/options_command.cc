#include <algorithm>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/commands/evaluate_options.h"
#include "apps/commands/mesh_options.h"
#include "apps/commands/option_binding.h"
#include "apps/run/pipeline.h"
#include "apps/run/solver_comparison.h"
#include "core/support/options.h"
#include "core/synthetic/synthetic.h"

namespace burin {
namespace {

// Calls visit(command, options) for each command that has options, with their defaults.
void ForEachCommand(const std::function<void(const std::string&, const OptionSet&)>& visit) {
  PipelineOptions refine;
  MeshCommandOptions mesh;
  SyntheticOptions synth;
  EvaluateOptions evaluate;
  CompareOptions compare;
  OptionSet refine_set;
  OptionSet mesh_set;
  OptionSet synth_set;
  OptionSet evaluate_set;
  OptionSet compare_set;
  refine.Describe(&refine_set);
  mesh.Describe(&mesh_set);
  synth.Describe(&synth_set);
  evaluate.Describe(&evaluate_set);
  compare.Describe(&compare_set);
  visit("burin refine", refine_set);
  visit("burin mesh", mesh_set);
  visit("burin synth", synth_set);
  visit("burin evaluate", evaluate_set);
  visit("burin compare-solvers, beside those of refine", compare_set);
}

void PrintPlain() {
  ForEachCommand([](const std::string& command, const OptionSet& set) {
    size_t width = 0;
    for (const Option& option : set.options()) width = std::max(width, option.name.size());
    std::cout << command << "\n";
    for (const Option& option : set.options()) {
      std::cout << "  --" << option.name << std::string(width + 2 - option.name.size(), ' ')
                << (option.Text().empty() ? "empty" : option.Text()) << "  (" << option.Constraint()
                << ")  " << option.help << "\n";
    }
  });
}

// As roff wants it: a backslash, and a dot or quote that would begin a request, are escaped; a minus is
// one that can be copied.
std::string Roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\' || c == '-') escaped += '\\';
    escaped += c;
    if (c == '\\') escaped += 'e';
  }
  if (!escaped.empty() && (escaped[0] == '.' || escaped[0] == '\'')) escaped.insert(0, "\\&");
  return escaped;
}

// The commands and their arguments are as the program parses them, the options those of the structs.
void PrintManual(const Program& program) {
  std::cout << ".TH BURIN 1 \"\" \"burin " << program.Version() << "\" \"User Commands\"\n"
            << ".SH NAME\nburin \\- " << Roff(program.Help())
            << "\n.SH SYNOPSIS\n.B burin\n.I COMMAND\n[arguments] [\\-\\-OPTION VALUE ...]\n"
            << ".SH COMMANDS\n";
  for (const CommandHelp& help : program.Commands()) {
    std::cout << ".TP\n.B " << Roff(help.command.name) << "\n" << Roff(help.command.help) << "\n";
    for (const CommandHelp::Line& argument : help.arguments) {
      // Options of the structs have a dot in their names; they follow below.
      if (argument.name.find('.') != std::string::npos) continue;
      if (argument.name == "--help") continue;
      std::cout << ".br\n" << Roff(argument.name) << ": " << Roff(argument.help) << "\n";
    }
  }
  ForEachCommand([](const std::string& command, const OptionSet& set) {
    std::cout << ".SH OPTIONS OF " << Roff(command) << "\n";
    for (const Option& option : set.options()) {
      std::cout << ".TP\n.B \\-\\-" << Roff(option.name) << "\n"
                << Roff(option.help + " (" + option.Constraint() +
                        "; default: " + (option.Text().empty() ? "empty" : option.Text()) + ")")
                << "\n";
    }
  });
  std::cout
      << ".SH EXIT STATUS\n0: done. 2: wrong input or options, one line says what. 3: the run "
         "would not fit into memory. 130, 143: interrupted; \\-\\-resume goes on.\n";
}

}  // namespace

std::string OptionsDocument() {
  std::string text =
      "# Options\n\nGenerated from the options structs by `burin options --markdown`; do not edit. "
      "Each option is a\ncommand-line flag and, without the `--`, a key of the TOML file given to "
      "`--config`.\n`--print-config` writes such a file with the options in use.\n";
  ForEachCommand([&text](const std::string& command, const OptionSet& set) {
    text += "\n# " + command + "\n\n" + OptionsMarkdown(set);
  });
  return text;
}

void AddOptionsCommand(Program* program) {
  Command command = program->Add("options", "list the options of all commands");
  const auto markdown = std::make_shared<bool>(false);
  command.Flag("--markdown", markdown.get(), "as the page docs/options.md");
  const auto manual = std::make_shared<bool>(false);
  command.Flag("--man", manual.get(), "as the manual page burin(1)");
  command.OnRun([markdown, manual, program] {
    if (*markdown) {
      std::cout << OptionsDocument();
    } else if (*manual) {
      PrintManual(*program);
    } else {
      PrintPlain();
    }
  });
}

}  // namespace burin
