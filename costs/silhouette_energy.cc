#include "costs/silhouette_energy.h"

#include "costs/silhouette_round.h"

namespace burin {

void SilhouetteTermOptions::Describe(OptionSet* set) {
  set->Add(
      "silhouette.weight", &weight,
      "Weight of the contour's squared distance to the outlines of the masks, in pixels, summed "
      "over its length; 0 = off; needs masks.meaning = object",
      0, 1e9);
  set->Add("silhouette.membrane", &membrane,
           "Weight of the squared difference of the displacements of neighbours since the level "
           "began, in "
           "pixels, on thin parts and others that outlines alone support",
           0, 1e9);
  set->Add("silhouette.rounds", &rounds,
           "More rounds on the finest level: thin parts take part there only", 0, 100);
}

std::unique_ptr<TermRound> SilhouetteEnergy::Freeze(const RoundContext& context) {
  return std::make_unique<SilhouetteRound>(options_, context);
}

}  // namespace burin
