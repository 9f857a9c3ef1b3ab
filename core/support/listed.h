// Names in a sentence.
#pragma once

#include <string>
#include <vector>

namespace burin {

// "a.jpg", "a.jpg, b.jpg" or "a.jpg, b.jpg, c.jpg and 7 more". There is one at least.
std::string Listed(const std::vector<std::string>& names);

}  // namespace burin
