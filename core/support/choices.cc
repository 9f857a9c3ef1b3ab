#include "core/support/choices.h"

#include <glog/logging.h>

namespace burin {

void FailWithoutName(int value) { LOG(FATAL) << "ChoicesOf() has no name for value " << value; }

}  // namespace burin
