// From one OptionSet: command-line flags, config file, --print-config, JSON and the documentation.
// A command describes its options struct once and calls BindOptions(); nothing else names an
// option.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/options.h"

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

// {"group.name": value, ...} with the JSON type of each option, in the order of the set.
nlohmann::ordered_json OptionsJson(const OptionSet& set);

// A Markdown table of name, default (the present value), permitted values and help, one for each
// group, under headings "## group".
std::string OptionsMarkdown(const OptionSet& set);

}  // namespace burin
