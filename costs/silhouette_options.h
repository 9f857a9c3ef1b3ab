// The options of the silhouette term (costs/silhouette_energy.h).
#pragma once

#include "core/support/options.h"

namespace burin {

struct SilhouetteTermOptions {
  double weight = 0;
  double membrane = 3;
  void Describe(OptionSet* set);
};

}  // namespace burin
