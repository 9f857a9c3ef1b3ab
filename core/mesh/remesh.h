// A surface covered anew with triangles of good shape and wanted size: incremental isotropic remeshing (Botsch and
// Kobbelt, "A remeshing approach to multiresolution modeling", 2004) on half-edges: long edges are split, short
// ones collapsed, edges flipped, vertices moved along the surface.
//
// What differs from the paper:
//  - Every vertex has its own edge length.
//  - Vertices are placed by least squares on the planes of the input under their facets (as in Kobbelt et al.,
//    "Feature sensitive surface extraction from volume data", 2001), not projected: edges and corners of boxes stay
//    sharp without being marked.
//  - A vertex knows its place on the input and finds the next by a walk from there (core/mesh/surface_walk.h):
//    sheets that lie close to each other are never confused.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

struct RemeshOptions {
  // Of split, collapse, flip and relax, before slivers are mended and vertices placed. 0: only the latter, for a mesh
  // that has the right sizes already.
  int iterations = 4;
};

// The place on the input that a new vertex stands for: where a caller reads what a vertex knew.
struct RemeshedVertex {
  int facet = -1;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  // of its corners: not negative, sum 1
};

struct Remeshed {
  TriangleMesh mesh;               // every vertex has a facet
  std::vector<RemeshedVertex> on;  // by vertex of `mesh`
  std::vector<int> kept;  // by facet of `mesh`: the input facet that it is, -1 if it is new
  int split_count = 0;
  int collapse_count = 0;
  int flip_count = 0;
};

// `edge_length`: by vertex of `mesh`, world units, > 0. `keep`, where given: by facet, 1 for what stays as it is;
// the corners of such facets do not move either.
//
// The result has the input's topology: closed surfaces stay closed, each border stays, near to where it was; no
// facet faces away from the input that did not before. Facets without area go, unless nothing around them
// allows it. Edges of more than two facets and vertices where fans of facets touch stay as they are; facets
// that repeat a vertex are left out. The same result for any number of threads.
Remeshed Remesh(const TriangleMesh& mesh, const std::vector<double>& edge_length,
                const RemeshOptions& options, const std::vector<char>* keep = nullptr);

}  // namespace burin
