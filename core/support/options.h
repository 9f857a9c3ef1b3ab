// How an options struct tells its fields to everything that needs them: command line, TOML config,
// --print-config, generated docs, summary.json and validation all walk one OptionSet.
//
// An options struct is plain defaulted fields plus `void Describe(OptionSet* set)`, which adds each
// field once with its full name ("smooth.weight"), one-line help and permitted range or choices.
// A field of an enum class (core/support/choices.h) is text out here, the name of its value.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/support/choices.h"

namespace burin {

// A field of an enum class, by the names of its values.
struct ChoiceField {
  std::function<std::string()> get;
  std::function<bool(const std::string&)> set;  // false, and no change, when no value has the name
};

struct Option {
  using Value = std::variant<bool*, int*, double*, std::string*, ChoiceField>;

  std::string name;  // "group.field", snake_case, unit as suffix
  std::string help;  // one line
  Value value;       // never null; owned by the options struct
  double min = -std::numeric_limits<double>::infinity();  // inclusive, numbers only
  double max = std::numeric_limits<double>::infinity();   // inclusive, numbers only
  std::vector<std::string> choices = {};                  // text only; empty = any text

  // The value is text to users: a string or a choice.
  bool IsText() const;
  // The value as text that Set() accepts; doubles in the shortest form that reads back the same.
  std::string Text() const;
  // visitor(value), the value as bool, int, double or text.
  template <typename Visitor>
  auto Visit(const Visitor& visitor) const;
  // Parses and assigns. False with *error = "name = text: constraint" when it does not fit.
  bool Set(const std::string& text, std::string* error);
  // The value obeys range and choices. False with *error = "name = value: constraint".
  bool Check(std::string* error) const;
  // "number in [0, 1]", "one of a, b", "true or false", ...
  std::string Constraint() const;
};

class OptionSet {
 public:
  void Add(const std::string& name, bool* value, const std::string& help);
  void Add(const std::string& name, int* value, const std::string& help, double min, double max);
  void Add(const std::string& name, double* value, const std::string& help, double min, double max);
  // `choices`: names that only a running program knows; those that the source knows are an enum.
  void Add(const std::string& name, std::string* value, const std::string& help,
           std::vector<std::string> choices = {});
  // The choices are ChoicesOf(*value).
  template <typename Enum, typename = std::enable_if_t<std::is_enum_v<Enum>>>
  void Add(const std::string& name, Enum* value, const std::string& help);

  std::vector<Option>& options() { return options_; }
  const std::vector<Option>& options() const { return options_; }
  Option* Find(const std::string& name);  // null when there is none

  // Every option obeys its constraint; *error names the first that does not.
  bool IsValid(std::string* error) const;

 private:
  void Add(Option option);

  std::vector<Option> options_;
};

template <typename Visitor>
auto Option::Visit(const Visitor& visitor) const {
  if (const auto* flag = std::get_if<bool*>(&value)) return visitor(**flag);
  if (const auto* integer = std::get_if<int*>(&value)) return visitor(**integer);
  if (const auto* real = std::get_if<double*>(&value)) return visitor(**real);
  return visitor(Text());
}

template <typename Enum, typename>
void OptionSet::Add(const std::string& name, Enum* value, const std::string& help) {
  Option option{name, help,
                ChoiceField{[value] { return NameOf(*value); },
                            [value](const std::string& text) { return SetByName(text, value); }}};
  for (const auto& choice : ChoicesOf(*value)) option.choices.emplace_back(choice.second);
  Add(std::move(option));
}

}  // namespace burin
