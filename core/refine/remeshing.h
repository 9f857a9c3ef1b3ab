// The surface of a refinement covered anew with well-shaped triangles within the finest level (core/mesh/remesh.h), whose edges
// are as long as the surface allows in the pixels that show it. What a vertex knows goes with it.
#pragma once

#include <vector>

#include "core/mesh/mesh_order.h"
#include "core/mesh/remesh.h"
#include "core/refine/refinement_options.h"
#include "core/refine/refinement_state.h"
#include "core/visibility/view_domain.h"

namespace burin {

// Wanted lengths of the edges at every vertex of `mesh`, whose facets the views of `cameras` see that `domains` list.
std::vector<double> WantedEdges(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                                const std::vector<ViewDomain>& domains,
                                const RemeshingOptions& options);

// Longer by one factor where facets of these edges would be more than `max_faces`: whether they are. (A facet of edge l has
// sqrt(3)/4 l^2; those that are made are up to a tenth smaller.)
bool StretchToFit(const TriangleMesh& mesh, int max_faces, std::vector<double>* edge_length);

// `mesh` is the state's in the order `order`. What it was goes to state->remesh_start, unless that has a mesh.
void RemeshState(const TriangleMesh& mesh, const MeshOrder& order,
                 const std::vector<double>& edge_length, const RemeshOptions& options,
                 RefinementState* state);

// The state's mesh as it was.
void UndoRemeshing(RefinementState* state);

}  // namespace burin
