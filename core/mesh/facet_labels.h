// Yes or no for every facet of a mesh, made to hang together along the surface: what is cut away by it leaves smooth
// rims, no specks, and no small holes.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// Facets that share an edge with each facet, ascending, as rows of an Adjacency by facet.
Adjacency FacetNeighbors(const TriangleMesh& mesh);

// The mean over each facet and its neighbours, again and again. What is not a number takes no part and stays.
void DiffuseOverFacets(const Adjacency& neighbors, int steps, std::vector<float>* values);

// The facets with chosen[f] = 1 that hang together over common edges: ascending lists, by their first facets.
std::vector<std::vector<int>> FacetPatches(const Adjacency& neighbors,
                                           const std::vector<char>& chosen);

// `cut` is 1 for facets to be cut away. Four steps of diffusion over facets that share an edge, to the nearer label; single
// teeth of the rim are filled. Then patches of facets to be cut with less than kLeastPatchPx square pixels that border on
// others are kept (holes), and such patches of others that border on facets to be cut are cut (islands). Where what is left
// would touch itself at a vertex only, it is left whole there. `area_px`: square pixels by facet; `neighbors`:
// FacetNeighbors(mesh).
constexpr double kLeastPatchPx = 200;
std::vector<char> SmoothedLabels(const TriangleMesh& mesh, const Adjacency& neighbors,
                                 const std::vector<double>& area_px, std::vector<char> cut);

}  // namespace burin
