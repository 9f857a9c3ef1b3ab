// The surface of a refinement covered anew with well-shaped triangles after the finest level (core/mesh/remesh.h), whose edges
// are as long as the surface allows in the pixels that show it. What a vertex knows goes with it.
#pragma once

#include <vector>

#include "core/mesh/mesh_order.h"
#include "core/mesh/remesh.h"
#include "core/refine/refinement_options.h"
#include "core/refine/refinement_state.h"
#include "core/visibility/view_domain.h"

namespace burin {

// `mesh` is the state's in the order `order`; the views of `cameras` see the facets that `domains` list. What it was goes to
// state->remesh_start.
void RemeshState(const TriangleMesh& mesh, const MeshOrder& order,
                 const std::vector<Camera>& cameras, const std::vector<ViewDomain>& domains,
                 const RemeshingOptions& options, RefinementState* state);

// The state's mesh as it was.
void UndoRemeshing(RefinementState* state);

}  // namespace burin
