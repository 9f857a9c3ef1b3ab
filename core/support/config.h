// Options as a TOML file: what `--config` reads and `--print-config` writes. An experiment is such
// a file, so nothing in it may pass unnoticed: an unknown key, a key set twice, a value of another
// type or out of range is an error that names file, line and key.
//
// toml++ reads it: TOML 1.0. Arrays, inline tables and dates are refused, since no option takes one.
// toml++ cannot write comments, so ConfigText() puts the file together and leaves values to it.
#pragma once

#include <filesystem>
#include <string>

#include "core/support/options.h"

namespace burin {

// Assigns every key of the file to the option of that full name. A whole number is accepted for a
// real option, not the reverse. Options that the file does not name keep their value. Throws
// InputError "FILE:LINE: key: reason", or "FILE:LINE: the line: reason" for what is not TOML; the
// options are then partly assigned.
void ReadConfig(const std::filesystem::path& path, OptionSet* set);

// The same for text at hand; `name` stands for the file in errors.
void ParseConfig(const std::string& text, const std::string& name, OptionSet* set);

// Every option as a TOML file, help and constraint as comments, that ParseConfig() reads back to
// identical values. Text that is not UTF-8 does not: TOML has no way to hold it.
std::string ConfigText(const OptionSet& set);

}  // namespace burin
