// Which vertices a round has evidence for, and which of the others may move.
//
// A vertex is supported when a term has data about where it is (TermRound::MarkSupported): for the photometric
// term, when a window that counts has a tap on one of its facets. Where nothing supports a vertex, smoothness
// alone would move it: it shrinks what is thin and breaks it. But in the gaps of a surface that is well
// supported, beside depth steps and on rough spots, smoothness is what brings the windows back. So a vertex
// that is seen moves as well where a good share of the surface around it is supported. The others keep their
// shape (core/refine/carry.h). So do, while they move, parts thinner than a window (core/refine/thin_parts.h):
// there smoothness acts on displacements and not on positions.
//
// Outlines of the object support vertices too (TermRound::MarkOutlined). What they alone support, and what is thin between
// them, is free and keeps its shape.
#pragma once

#include <vector>

#include "core/mesh/mesh_order.h"
#include "core/refine/refinement_options.h"
#include "core/solve/energy_term.h"

namespace burin {

// Asks the terms at the positions of the context's mesh and sets context->supported, moves, free and keeps_shape; none is
// free where cameras move. Adds
// what the round sees to `was_supported`, the state's (RefinementState), by `order`. Returns the number of
// supported vertices.
int FindSupport(const TermRounds& terms, const MeshOrder& order, HiddenVertices hidden,
                bool cameras_move, std::vector<char>* was_supported, RoundContext* context);

}  // namespace burin
