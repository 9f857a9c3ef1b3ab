// From one OptionSet: command-line flags, config file, --print-config and the documentation.
// A command describes its options struct once and calls BindOptions(); nothing else names an
// option.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "apps/run/scene_arguments.h"
#include "core/support/options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace burin {

// Gives `app` a flag --NAME VALUE for each option (help grouped by the part before the first dot),
// and
//   --config FILE    TOML, read before any flag whatever their order; may be repeated, later wins
//   --print-config   writes all options as they then are, as TOML, and ends the program; positional
//                    and required arguments may be missing. `check`, where given, comes first: it
//                    throws for options that do not fit together
// Values are assigned while CLI11 parses. A value that does not fit, or a fault in a config file,
// throws InputError. `set` must outlive the parsing of `app`.
// `short_flags` gives options a second spelling: {"synth.scene", "--scene"}.
void BindOptions(OptionSet* set, CLI::App* app,
                 const std::map<std::string, std::string>& short_flags = {},
                 const std::function<void()>& check = {});

// Adds SCENE and --images to a command and, for one that looks at photographs, --masks. Returns the
// options: SCENE first.
std::vector<CLI::Option*> BindScene(SceneArguments* source, CLI::App* app, bool photographs);

// A Markdown table of name, default (the present value), permitted values and help, one for each
// group, under headings "## group".
std::string OptionsMarkdown(const OptionSet& set);

}  // namespace burin
