// Numbers as text with a fixed number of decimals.
#pragma once

#include <string>

namespace burin {

// "0.50" for .5 and two digits.
std::string Fixed(double value, int digits);

// A share in percent: "0 %", "less than 0.1 %", "4.2 %", "23 %".
std::string PercentText(double share);

}  // namespace burin
