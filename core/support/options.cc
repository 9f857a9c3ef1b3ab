#include "core/support/options.h"

#include <glog/logging.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace burin {
namespace {

template <typename Number>
std::string NumberText(Number number) {
  char buffer[64];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), number);
  return {buffer, result.ptr};
}

template <typename Number>
bool ParseNumber(const std::string& text, Number* number) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), *number);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

}  // namespace

bool Option::IsText() const {
  return std::holds_alternative<std::string*>(value) || std::holds_alternative<ChoiceField>(value);
}

std::string Option::Text() const {
  if (const auto* flag = std::get_if<bool*>(&value)) return **flag ? "true" : "false";
  if (const auto* integer = std::get_if<int*>(&value)) return NumberText(**integer);
  if (const auto* real = std::get_if<double*>(&value)) return NumberText(**real);
  if (const auto* text = std::get_if<std::string*>(&value)) return **text;
  return std::get<ChoiceField>(value).get();
}

bool Option::Set(const std::string& text, std::string* error) {
  bool parsed = true;
  if (auto* flag = std::get_if<bool*>(&value)) {
    parsed = text == "true" || text == "false";
    if (parsed) **flag = text == "true";
  } else if (auto* integer = std::get_if<int*>(&value)) {
    parsed = ParseNumber(text, *integer);
  } else if (auto* real = std::get_if<double*>(&value)) {
    parsed = ParseNumber(text, *real);
  } else if (auto* field = std::get_if<std::string*>(&value)) {
    **field = text;
  } else {
    parsed = std::get<ChoiceField>(value).set(text);
  }
  if (parsed) return Check(error);
  *error = name + " = " + text + ": must be " + Constraint();
  return false;
}

bool Option::Check(std::string* error) const {
  bool fits = true;
  if (const auto* integer = std::get_if<int*>(&value)) {
    fits = **integer >= min && **integer <= max;
  } else if (const auto* real = std::get_if<double*>(&value)) {
    fits = std::isfinite(**real) && **real >= min && **real <= max;
  } else if (const auto* text = std::get_if<std::string*>(&value)) {
    fits = choices.empty() || std::find(choices.begin(), choices.end(), **text) != choices.end();
  }
  if (!fits) *error = name + " = " + Text() + ": must be " + Constraint();
  return fits;
}

std::string Option::Constraint() const {
  if (std::holds_alternative<bool*>(value)) return "true or false";
  if (IsText()) {
    if (choices.empty()) return "text";
    std::string list = "one of ";
    for (size_t i = 0; i < choices.size(); ++i) list += (i == 0 ? "" : ", ") + choices[i];
    return list;
  }
  std::string kind = std::holds_alternative<int*>(value) ? "a whole number" : "a number";
  const bool has_min = std::isfinite(min);
  const bool has_max = std::isfinite(max);
  if (has_min && has_max) return kind + " in [" + NumberText(min) + ", " + NumberText(max) + "]";
  if (has_min) return kind + " >= " + NumberText(min);
  if (has_max) return kind + " <= " + NumberText(max);
  return kind;
}

void OptionSet::Add(Option option) {
  CHECK(Find(option.name) == nullptr) << option.name;
  options_.push_back(std::move(option));
}

void OptionSet::Add(const std::string& name, bool* value, const std::string& help) {
  Add({name, help, value});
}

void OptionSet::Add(const std::string& name, int* value, const std::string& help, double min,
                    double max) {
  Add({name, help, value, min, max});
}

void OptionSet::Add(const std::string& name, double* value, const std::string& help, double min,
                    double max) {
  Add({name, help, value, min, max});
}

void OptionSet::Add(const std::string& name, std::string* value, const std::string& help,
                    std::vector<std::string> choices) {
  Option option{name, help, value};
  option.choices = std::move(choices);
  Add(std::move(option));
}

Option* OptionSet::Find(const std::string& name) {
  for (Option& option : options_) {
    if (option.name == name) return &option;
  }
  return nullptr;
}

bool OptionSet::IsValid(std::string* error) const {
  return std::all_of(options_.begin(), options_.end(),
                     [error](const Option& option) { return option.Check(error); });
}

}  // namespace burin
