// Numbers as text with a fixed number of decimals.
#pragma once

#include <string>

namespace burin {

// "0.50" for .5 and two digits.
std::string Fixed(double value, int digits);

}  // namespace burin
