#include "core/support/fixed_text.h"

#include <sstream>

namespace burin {

std::string Fixed(double value, int digits) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  text << value;
  return text.str();
}

std::string PercentText(double share) {
  if (share <= 0) return "0 %";
  if (share < 0.001) return "less than 0.1 %";
  return Fixed(100 * share, share < 0.0995 ? 1 : 0) + " %";
}

}  // namespace burin
