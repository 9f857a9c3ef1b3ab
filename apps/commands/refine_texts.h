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
// Of a level whose splitting was stopped.
std::string UnsplitText(const LevelSummary& level);
std::string LeftOutText(const LevelSummary& level);
// Of a level that was undone, or parts of it.
std::string UndoneText(const LevelSummary& level);
// What of the surface passes through itself, before a level and after it (guard.crossings).
std::string CrossingsText(const LevelSummary& level);
// What became of the part of a level that was done when the run was stopped.
std::string InterruptedText(const LevelSummary& level);

}  // namespace burin
