// What `burin refine` says on the way.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/refine/refinement_parts.h"
#include "core/refine/refinement_state.h"

namespace burin {

std::string EventText(const RefinementEvent& event);
// Which views, of these names, a level leaves out, and which it reduces less than others; empty when none.
std::string ViewsText(const RoundContext& context, const std::vector<std::string>& names);
std::string RoundText(const RoundContext& context, const TriangleMesh& mesh,
                      const RoundSummary& round);
// What became of a level, and what of its surface passes through itself (guard.crossings).
std::vector<std::string> LevelTexts(const LevelSummary& level, bool crossings);

}  // namespace burin
