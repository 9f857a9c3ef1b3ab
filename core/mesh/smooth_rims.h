// Borders of a mesh made smooth: those that a cut along facets leaves have teeth.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// Moves the vertices with free[v] = 1 on the mesh's borders along the surface and towards the middle of their two
// neighbours on the border, in ten steps forward and ten back (Taubin 1995), so that borders lose their teeth and keep their
// place. A step that would make a facet worse than a quality (4 sqrt(3) area / squared edges) of .5 and than it was, or turn
// it by more than 60 degrees, is not made. Vertices where borders meet stay.
void SmoothRims(const std::vector<char>& free, TriangleMesh* mesh);

}  // namespace burin
