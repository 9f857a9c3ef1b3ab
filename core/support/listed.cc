#include "core/support/listed.h"

#include <algorithm>

namespace burin {

std::string Listed(const std::vector<std::string>& names) {
  constexpr size_t kShown = 3;
  std::string text = names[0];
  for (size_t k = 1; k < std::min(kShown, names.size()); ++k) text += ", " + names[k];
  if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
  return text;
}

}  // namespace burin
