// A mesh whose axes another program calls otherwise: which of the 24 rotations that map axes to axes makes it
// fit the photographs.
#pragma once

#include <string>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "selection/pairs_options.h"

namespace burin {

// For a mesh that does not fit as it is. "with its axes turned the mesh would fit: take x, -z, y for its x, y,
// z" after the rotation about the origin, or about the middle of the mesh, with which most windows agree
// (core/evidence/verdict.h: E of .5, A of .7). Empty when there is none. Takes some seconds: at most eight
// views are looked at.
std::string TurnedAxes(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options);

}  // namespace burin
