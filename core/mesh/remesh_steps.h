// The steps that core/mesh/remesh.h repeats. None changes the surface's topology, turns a facet over, or touches what
// is fixed. They go over the surface in one order; what runs in parallel writes what it owns.
#pragma once

#include <utility>
#include <vector>

#include "core/mesh/remesh_state.h"

namespace burin {

constexpr double kTooLong = 4.0 / 3;  // of the wanted length

// Edges and what they are sorted by, ascending; by index where that is equal.
using EdgeQueue = std::vector<std::pair<double, OpenMesh::EdgeHandle>>;
void SortQueue(EdgeQueue* queue);

// Halves edges that are longer than 4/3 of what is wanted, the longest of a facet first. Returns how many.
int SplitLongEdges(RemeshState* state);

// Collapses edges that are shorter than 4/5 of what is wanted, shortest first, where no edge becomes longer than 4/3
// and no facet bad by it: to the middle, or to the end that keeps the surface where it is. Returns how many.
int CollapseShortEdges(RemeshState* state);

// Collapses the shortest edge of every facet of a quality below `least_quality`, whatever its length, where that does no
// harm. Returns how many.
int CollapseSlivers(RemeshState* state, double least_quality);

enum class FlipFor { kValence, kQuality };
// Flips edges for degrees near to six (four at borders), or for a larger smaller quality of the two facets; and for
// the surface: of two diagonals that are far apart the one that lies nearer to the input. Returns how many.
int FlipEdges(RemeshState* state, FlipFor goal);

enum class RelaxOn { kSurface, kPlanes };
// Moves vertices along the surface to the middle of their facets, with weights area / wanted length^2:
//  kSurface: in the directions in which their facets' planes leave them free (along a sharp edge, not off it), then
//            onto the input;
//  kPlanes: and, in the directions in which the planes of the input under their facets hold them, to the point that
//           fits those best.
// At borders lines take the place of planes. Vertices of facets that become bad by it go back.
void Relax(RemeshState* state, RelaxOn on);

}  // namespace burin
