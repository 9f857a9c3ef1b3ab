// The options of the silhouette term (costs/silhouette_energy.h).
#pragma once

#include "core/support/options.h"

namespace burin {

struct SilhouetteTermOptions {
  double weight = 0;  // 0 = the term is off
  double membrane = 3;
  int rounds = 4;  // more on the finest level
  void Describe(OptionSet* set);
};

}  // namespace burin
