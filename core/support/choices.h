// An option with choices is an enum class in the program and names for its users. The one place that
// pairs them is a function beside the enum, in the order in which users read the names:
//
//   enum class Motion { kNormal, kFree };
//   inline Choices<Motion> ChoicesOf(Motion) {
//     return {{Motion::kNormal, "normal"}, {Motion::kFree, "free"}};
//   }
//
// What is below, and OptionSet::Add, finds it by the type.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace burin {

template <typename Enum>
using Choices = std::vector<std::pair<Enum, const char*>>;

// Ends the program: ChoicesOf() has left out a value.
[[noreturn]] void FailWithoutName(int value);

template <typename Enum>
std::string NameOf(Enum value) {
  for (const auto& [choice, name] : ChoicesOf(value)) {
    if (choice == value) return name;
  }
  FailWithoutName(static_cast<int>(value));
}

// False, with *value as it was, when no choice has the name.
template <typename Enum>
bool SetByName(const std::string& name, Enum* value) {
  for (const auto& [choice, known] : ChoicesOf(*value)) {
    if (name != known) continue;
    *value = choice;
    return true;
  }
  return false;
}

}  // namespace burin
