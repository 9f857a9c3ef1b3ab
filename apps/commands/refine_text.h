// The lines that burin refine prints on its way.
#pragma once

#include <string>

#include "core/mesh/mesh.h"
#include "core/refine/refinement.h"

namespace burin {

std::string EventText(const RefinementEvent& event);

std::string RoundText(const RoundContext& context, const TriangleMesh& mesh,
                      const RoundSummary& round);

// Facets are larger than asked for.
std::string UnsplitText(const LevelSummary& level);

std::string UndoneText(const LevelSummary& level);

// What became of the part of a level that was done when the run was stopped.
std::string InterruptedText(const LevelSummary& level);

}  // namespace burin
