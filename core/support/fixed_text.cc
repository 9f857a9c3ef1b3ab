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

}  // namespace burin
