// How an options struct tells its fields to everything that needs them: command line, TOML config,
// --print-config, generated docs, summary.json and validation all walk one OptionSet.
//
// An options struct is plain defaulted fields plus `void Describe(OptionSet* set)`, which adds each
// field once with its full name ("smooth.weight"), one-line help and permitted range or choices.
#pragma once

#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace burin {

struct Option {
  std::string name;  // "group.field", snake_case, unit as suffix
  std::string help;  // one line
  std::variant<bool*, int*, double*, std::string*>
      value;                                              // never null; owned by the options struct
  double min = -std::numeric_limits<double>::infinity();  // inclusive, numbers only
  double max = std::numeric_limits<double>::infinity();   // inclusive, numbers only
  std::vector<std::string> choices;                       // strings only; empty = any text

  // The value as text that Set() accepts; doubles in the shortest form that reads back the same.
  std::string Text() const;
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
  void Add(const std::string& name, std::string* value, const std::string& help,
           std::vector<std::string> choices = {});

  std::vector<Option>& options() { return options_; }
  const std::vector<Option>& options() const { return options_; }
  Option* Find(const std::string& name);  // null when there is none

  // Every option obeys its constraint; *error names the first that does not.
  bool IsValid(std::string* error) const;

 private:
  std::vector<Option> options_;
};

}  // namespace burin
