#include "core/support/config.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "core/support/did_you_mean.h"
#include "core/support/error.h"

namespace burin {
namespace {

// toml++ 3.3 makes a table of every part of a key a.b.c and calls itself for each when it destroys
// them: a key of thirty thousand parts would run out of stack. A file of all options has 26 dots.
constexpr int kMostDots = 5000;

// A value as TOML, on one line.
template <typename Value>
std::string TomlText(const Value& value) {
  std::ostringstream text;
  text << toml::toml_formatter(value, toml::format_flags::allow_unicode_strings);
  return text.str();
}

std::string Quoted(std::string text) { return TomlText(toml::value<std::string>(std::move(text))); }

// The kind that the option takes is the kind that was written.
bool KindFits(const Option& option, const toml::node& value) {
  if (std::holds_alternative<bool*>(option.value)) return value.is_boolean();
  if (std::holds_alternative<int*>(option.value)) return value.is_integer();
  return option.IsText() ? value.is_string() : value.is_number();
}

// Name of a kind that no option takes; empty for the others.
std::string RefusedKind(const toml::node& value) {
  if (value.is_table()) return "inline tables";
  if (value.is_array_of_tables()) return "arrays of tables";
  if (value.is_array()) return "arrays";
  const bool is_plain = value.is_boolean() || value.is_number() || value.is_string();
  return is_plain ? "" : "dates and times";
}

// A key of the file and what it names: a value, or a [group] with more keys.
struct Entry {
  const toml::key* key = nullptr;
  const toml::node* value = nullptr;
  int parent = -1;  // the group's entry; -1 at the top
};

bool IsGroup(const Entry& entry) {
  const toml::table* table = entry.value->as_table();
  return table != nullptr && !table->is_inline();
}

bool StandsBefore(const Entry& a, const Entry& b) {
  const toml::source_position& at_a = a.key->source().begin;
  const toml::source_position& at_b = b.key->source().begin;
  return std::pair(at_a.line, at_a.column) < std::pair(at_b.line, at_b.column);
}

bool IsBare(std::string_view part) {
  return !part.empty() && std::all_of(part.begin(), part.end(), [](unsigned char c) {
    return (c < 0x80 && std::isalnum(c) != 0) || c == '_' || c == '-';
  });
}

// "a.b.c". A part that needs quotes has them, so that the one part "a.b" is not taken for a.b.
std::string FullName(const std::vector<Entry>& entries, const Entry& entry) {
  const std::string part(entry.key->str());
  std::string name = IsBare(part) ? part : Quoted(part);
  for (int k = entry.parent; k >= 0; k = entries[k].parent) {
    const std::string group(entries[k].key->str());
    name.insert(0, (IsBare(group) ? group : Quoted(group)) + ".");
  }
  return name;
}

// Every entry of the file; a loop, since groups may lie deep in each other.
std::vector<Entry> EntriesOf(const toml::table& file) {
  std::vector<Entry> entries;
  const auto add = [&entries](const toml::table& table, int parent) {
    for (const auto& [key, value] : table) entries.push_back({&key, &value, parent});
  };
  add(file, -1);
  for (size_t k = 0; k < entries.size(); ++k) {
    if (IsGroup(entries[k])) add(*entries[k].value->as_table(), static_cast<int>(k));
  }
  return entries;
}

std::string Place(const std::string& name, int64_t line) {
  return name + ":" + std::to_string(line);
}

void CheckDots(const std::string& text, const std::string& name) {
  int dots = 0;
  int64_t line = 1;
  for (const char c : text) {
    line += c == '\n' ? 1 : 0;
    dots += c == '.' ? 1 : 0;
    if (dots > kMostDots) {
      throw InputError(Place(name, line), "has more than " + std::to_string(kMostDots) +
                                              " dots; this is not a file of options");
    }
  }
}

// toml++ says what is wrong and where; the line itself has the key.
InputError SyntaxError(const toml::parse_error& error, const std::string& text,
                       const std::string& name) {
  constexpr size_t kMostShown = 60;
  constexpr char kBlank[] = " \t\r";
  const int64_t number = error.source().begin.line;
  std::istringstream lines(text);
  std::string line;
  for (int64_t k = 0; k < number; ++k) std::getline(lines, line);
  line.erase(0, line.find_first_not_of(kBlank));
  line.erase(line.find_last_not_of(kBlank) + 1);
  const size_t value = line.find_first_not_of(kBlank, std::min(line.find('='), line.size()) + 1);
  const bool is_word =
      value != std::string::npos && std::isalpha(static_cast<unsigned char>(line[value])) != 0;
  return {Place(name, number), line.substr(0, kMostShown) + ": " +
                                   std::string(error.description()) +
                                   (is_word ? " (text needs quotes)" : "")};
}

std::vector<std::string> Names(const OptionSet& set) {
  std::vector<std::string> names;
  for (const Option& option : set.options()) names.push_back(option.name);
  return names;
}

}  // namespace

void ReadConfig(const std::filesystem::path& path, OptionSet* set) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw InputError(path, "is a folder, not a config file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, std::string("cannot be read: ") + std::strerror(errno));
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) throw InputError(path, "cannot be read");
  ParseConfig(text.str(), path.string(), set);
}

void ParseConfig(const std::string& text, const std::string& name, OptionSet* set) {
  CheckDots(text, name);
  toml::table file;
  try {
    file = toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw SyntaxError(error, text, name);
  }
  const std::vector<Entry> entries = EntriesOf(file);
  std::vector<Entry> values;
  std::copy_if(entries.begin(), entries.end(), std::back_inserter(values),
               [](const Entry& entry) { return !IsGroup(entry); });
  std::sort(values.begin(), values.end(), StandsBefore);
  for (const Entry& entry : values) {
    const std::string key = FullName(entries, entry);
    const toml::node& value = *entry.value;
    const auto fail = [&](const std::string& reason) {
      throw InputError(Place(name, entry.key->source().begin.line), key + ": " + reason);
    };
    if (const std::string kind = RefusedKind(value); !kind.empty()) {
      fail(kind + " are not supported");
    }
    Option* option = set->Find(key);
    if (option == nullptr) fail("unknown option" + DidYouMean(key, Names(*set)));
    const std::string shown = TomlText(value);
    const std::string plain = value.is_string() ? value.as_string()->get() : shown;
    std::string ignored;
    if (!KindFits(*option, value) || !option->Set(plain, &ignored)) {
      fail("must be " + option->Constraint() + ", not " + shown);
    }
  }
}

std::string ConfigText(const OptionSet& set) {
  // Grouped by the part before the last dot, groups in order of first appearance; keys without a
  // group come first, since TOML has no way back out of a table.
  std::vector<std::string> groups = {""};
  const auto group_of = [](const Option& option) {
    const size_t dot = option.name.rfind('.');
    return dot == std::string::npos ? std::string() : option.name.substr(0, dot);
  };
  for (const Option& option : set.options()) {
    const std::string group = group_of(option);
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  std::string text;
  for (const std::string& group : groups) {
    if (!group.empty()) text += (text.empty() ? "[" : "\n[") + group + "]\n";
    for (const Option& option : set.options()) {
      if (group_of(option) != group) continue;
      text += "# " + option.help + " (" + option.Constraint() + ")\n";
      text += group.empty() ? option.name : option.name.substr(group.size() + 1);
      text += " = " + (option.IsText() ? Quoted(option.Text()) : option.Text()) + "\n";
    }
  }
  return text;
}

}  // namespace burin
