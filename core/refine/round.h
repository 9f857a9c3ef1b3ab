// Makes the frozen state of a round from cameras, pairs and mesh: visibility, neighbourhoods,
// normals, what is seen.
#pragma once

#include <vector>

#include "core/scene/pairs.h"
#include "core/solve/energy_term.h"

namespace burin {

// The pairs of which both views take part.
std::vector<CameraPair> TakingPart(const std::vector<CameraPair>& pairs,
                                   const std::vector<LevelView>& views);

// Casts Omega_ij for the pairs of views that take part and fills a context that refers to `views`, `mesh` and `domains`,
// which must outlive it. `border_px`: see RayCaster::Cast. `supported` and `moves` are left equal to `seen`:
// the terms are the caller's to ask.
//
// `held_back`, where given, gets the Omega_ij of `held_back_pairs` and must outlive the context too.
RoundContext FreezeRound(const std::vector<LevelView>& views, const std::vector<CameraPair>& pairs,
                         const TriangleMesh& mesh, Motion motion, double border_px,
                         std::vector<ViewDomain>* domains,
                         const std::vector<CameraPair>& held_back_pairs = {},
                         std::vector<ViewPartners>* held_back = nullptr);

}  // namespace burin
