// What can be wrong with a mesh, counted; and the repairs that change no geometry.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct MeshReport {
  int vertex_count = 0;
  int face_count = 0;     // triangles, after the repairs below
  int polygon_count = 0;  // faces with more than three vertices, cut into triangles
  int degenerate_face_count =
      0;  // that repeat a vertex index or have zero area; reading drops them
  int duplicate_face_count =
      0;  // faces beyond the first on the same three vertices; reading drops them
  int duplicate_vertex_count = 0;  // vertices beyond the first at the same position
  int welded_vertex_count = 0;     // joined with another at the same position (core/mesh/weld.h)
  int unreferenced_vertex_count = 0;
  int boundary_edge_count = 0;      // edges of one face
  int nonmanifold_edge_count = 0;   // edges of more than two faces
  int inconsistent_edge_count = 0;  // edges that two faces traverse in the same direction
  int reoriented_face_count = 0;    // faces flipped by OrientConsistently
  int component_count = 0;          // faces connected through common vertices

  // "9794 vertices, 19375 faces, 3 components, 211 boundary edges; 4 degenerate faces, ..."; a
  // count of something wrong is named only when it is not zero.
  std::string Brief() const;
};

// Counts everything but polygon_count, welded_vertex_count and reoriented_face_count, which are zero. Indices must be in
// range. A face has zero area when its height is below 1e-12 of its longest edge.
MeshReport CheckMesh(const TriangleMesh& mesh);

// Takes out the faces that repeat a vertex index or have zero area; returns how many. Where corners of
// such a face lie at one place its neighbours get one vertex for them, so that taking it out leaves no
// slit. Vertices keep their indices.
int DropDegenerateFaces(TriangleMesh* mesh);

// Flips faces so that neighbours agree: across each edge of exactly two faces one goes forward and
// one back. The minority of each edge-connected component is flipped; a component that cannot be
// oriented (a Moebius strip) is left as it is, and so is one that already agrees. Returns the
// number of faces flipped.
int OrientConsistently(TriangleMesh* mesh);

}  // namespace burin
