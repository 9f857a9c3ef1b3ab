#include <algorithm>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "apps/evaluate_options.h"
#include "apps/option_binding.h"
#include "apps/pipeline.h"
#include "apps/solver_comparison.h"
#include "core/options.h"
#include "core/synthetic.h"

namespace burin {
namespace {

// Calls visit(command, options) for each command that has options, with their defaults.
void ForEachCommand(const std::function<void(const std::string&, const OptionSet&)>& visit) {
  PipelineOptions refine;
  SyntheticOptions synth;
  EvaluateOptions evaluate;
  CompareOptions compare;
  OptionSet refine_set;
  OptionSet synth_set;
  OptionSet evaluate_set;
  OptionSet compare_set;
  refine.Describe(&refine_set);
  synth.Describe(&synth_set);
  evaluate.Describe(&evaluate_set);
  compare.Describe(&compare_set);
  visit("burin refine", refine_set);
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

void AddOptionsCommand(CLI::App* program) {
  CLI::App* app = program->add_subcommand("options", "list the options of all commands");
  const auto markdown = std::make_shared<bool>(false);
  app->add_flag("--markdown", *markdown, "as the page docs/options.md");
  app->callback([markdown] {
    if (*markdown) {
      std::cout << OptionsDocument();
    } else {
      PrintPlain();
    }
  });
}

}  // namespace burin
