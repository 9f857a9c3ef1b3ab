// The steps that core/mesh/remesh.h repeats. None changes the surface's topology, turns a facet over, or touches what
// is fixed. They go over the surface in one order; what runs in parallel writes what it owns.
#pragma once

#include "core/mesh/remesh_state.h"

namespace burin {

// Halves edges that are longer than 4/3 of what is wanted, longest first. Returns how many.
int SplitLongEdges(RemeshState* state);

// Collapses edges that are shorter than 4/5 of what is wanted, shortest first, where no edge becomes longer than 4/3
// and no facet bad by it: to the middle, or to the end that keeps the surface where it is. Returns how many.
int CollapseShortEdges(RemeshState* state);

// Collapses what shortest edges of facets of a quality below `least_quality` can be collapsed, whatever their length.
int CollapseSlivers(RemeshState* state, double least_quality);

enum class FlipFor { kValence, kQuality };
// Flips edges for degrees near to six (four at borders), or for a larger smaller quality of the two facets; and for
// the surface: of two diagonals that are far apart the one that lies nearer to the input.
int FlipEdges(RemeshState* state, FlipFor goal);

enum class RelaxOn { kSurface, kPlanes };
// Moves vertices along the surface to the middle of their facets, with weights area / wanted length^2; then
//  kSurface: onto the input;
//  kPlanes: onto the point that fits the planes of the input under their facets best, in the directions in which
//           those say anything. Vertices of borders fit the lines of the input's border.
void Relax(RemeshState* state, RelaxOn on);

}  // namespace burin
