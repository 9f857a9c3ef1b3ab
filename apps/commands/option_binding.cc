#include "apps/commands/option_binding.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <vector>

#include "core/support/config.h"
#include "core/support/error.h"

namespace burin {
namespace {

std::string GroupOf(const Option& option) {
  const size_t dot = option.name.find('.');
  return dot == std::string::npos ? "general" : option.name.substr(0, dot);
}

std::vector<std::string> Groups(const OptionSet& set) {
  std::vector<std::string> groups;
  for (const Option& option : set.options()) {
    if (std::find(groups.begin(), groups.end(), GroupOf(option)) == groups.end()) {
      groups.push_back(GroupOf(option));
    }
  }
  return groups;
}

std::string Placeholder(const Option& option) {
  if (std::holds_alternative<bool*>(option.value)) return "[true|false]";
  if (std::holds_alternative<int*>(option.value)) return "INTEGER";
  if (std::holds_alternative<double*>(option.value)) return "NUMBER";
  return option.choices.empty() ? "TEXT" : "NAME";
}

std::string Default(const Option& option) {
  const std::string text = option.Text();
  return text.empty() ? "empty" : text;
}

// "help (a number >= 0; default 3)"
std::string Description(const Option& option) {
  return option.help + " (" + option.Constraint() + "; default " + Default(option) + ")";
}

std::string EscapedForTable(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

}  // namespace

void BindOptions(OptionSet* set, CLI::App* app,
                 const std::map<std::string, std::string>& short_flags,
                 const std::function<void()>& check) {
  // CLI11 runs the callbacks of the options that were given in the order in which the options were
  // added, not in that of the command line: --config first, --print-config last.
  app->add_option_function<std::vector<std::string>>(
         "--config",
         [set](const std::vector<std::string>& paths) {
           for (const std::string& path : paths) ReadConfig(path, set);
         },
         "TOML file with options; flags override it, a later --config an earlier one")
      ->option_text("FILE.toml")
      ->allow_extra_args(false);

  for (size_t i = 0; i < set->options().size(); ++i) {
    const Option& option = set->options()[i];
    const auto short_flag = short_flags.find(option.name);
    CLI::Option* flag = app->add_option_function<std::string>(
        (short_flag == short_flags.end() ? "" : short_flag->second + ",") + "--" + option.name,
        [set, i](const std::string& text) {
          Option& target = set->options()[i];
          std::string ignored;
          if (!target.Set(text, &ignored)) {
            throw InputError("--" + target.name + " " + text + ": must be " + target.Constraint());
          }
        },
        Description(option));
    flag->option_text(Placeholder(option))->group(GroupOf(option));
    // "--dtu.run" alone means "--dtu.run true"; what follows is taken as its value only when it is not
    // needed as a positional argument.
    if (std::holds_alternative<bool*>(option.value)) flag->expected(0, 1)->default_str("true");
  }

  app->add_flag_callback(
      "--print-config",
      [set, app, check] {
        if (app->remaining_size() > 0) throw CLI::ExtrasError(app->remaining());
        if (check) check();
        std::cout << ConfigText(*set) << std::flush;
        throw CLI::Success();
      },
      "write all options as TOML and stop");
}

std::vector<CLI::Option*> BindScene(SceneArguments* source, CLI::App* app, bool photographs) {
  std::vector<CLI::Option*> options;
  options.push_back(
      app->add_option("scene", source->scene,
                      "COLMAP workspace, NAME.mvs, sfm_data.json, NAME.nvm, bundle.out, "
                      "or a folder of camera files (docs/formats.md)")
          ->option_text("SCENE (required)"));
  options.push_back(app->add_option("--images", source->images,
                                    "folder of the photographs, where it is not the scene's own")
                        ->option_text("DIR"));
  options.push_back(app->add_option("--views", source->filter.views,
                                    "the views to be read, as names with * and ?, separated by "
                                    "commas")
                        ->option_text("PATTERNS"));
  options.push_back(app->add_option("--skip-views", source->filter.skip,
                                    "the views to be left out, in the same way")
                        ->option_text("PATTERNS"));
  if (photographs) {
    options.push_back(
        app->add_option(
               "--masks", source->masks,
               "folder of image masks, NAME.png for image NAME: pixels that are zero in them "
               "are not used")
            ->option_text("DIR"));
  }
  return options;
}

std::string OptionsMarkdown(const OptionSet& set) {
  std::string text;
  for (const std::string& group : Groups(set)) {
    text += (text.empty() ? "## " : "\n## ") + group + "\n\n";
    text += "| option | default | permitted | meaning |\n|---|---|---|---|\n";
    for (const Option& option : set.options()) {
      if (GroupOf(option) != group) continue;
      text += "| `--" + option.name + "` | `" + EscapedForTable(Default(option)) + "` | " +
              EscapedForTable(option.Constraint()) + " | " + EscapedForTable(option.help) + " |\n";
    }
  }
  return text;
}

}  // namespace burin
