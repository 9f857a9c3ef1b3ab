// The mesh as burin's numerics see it: positions and vertex indices, counter-clockwise seen from
// outside. core/mesh/mesh_io.h reads and writes it through OpenMesh, core/mesh/subdivide.h refines it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace burin {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  // world units
  std::vector<Eigen::Vector3i> faces;     // indices into vertices
};

// Neighbour lists in compressed rows: those of vertex v are index[start[v]] .. index[start[v+1]-1].
struct Adjacency {
  std::vector<int> start;  // vertex count + 1
  std::vector<int> index;
  int Degree(int v) const { return start[v + 1] - start[v]; }
  const int* Begin(int v) const { return index.data() + start[v]; }
  const int* End(int v) const { return index.data() + start[v + 1]; }
};

// Faces around each vertex, ascending. Face f appears once in the list of each of its vertices.
Adjacency VertexFaces(const TriangleMesh& mesh);

// Vertices sharing an edge with each vertex, ascending. Here and below `faces` = VertexFaces(mesh).
Adjacency VertexNeighbors(const TriangleMesh& mesh, const Adjacency& faces);

// How many vertices two faces have in common: two for neighbours across an edge. Without branches: whether
// faces touch is as good as random.
inline int CommonVertices(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  int common = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) common += static_cast<int>(a[i] == b[j]);
  }
  return common;
}
inline bool ShareVertex(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return CommonVertices(a, b) != 0;
}

// (V1-V0) x (V2-V0): outward, length twice the area.
Eigen::Vector3d FaceAreaNormal(const TriangleMesh& mesh, int face);

// Unit normals, area-weighted mean of the faces around a vertex; zero for a vertex without faces or
// with cancelling ones.
std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh, const Adjacency& faces);

// Vertices on an edge that has one face only (true = on the boundary).
std::vector<char> BoundaryVertices(const TriangleMesh& mesh, const Adjacency& faces);

// The facets that hang together through common vertices: ascending lists, by their first facets.
std::vector<std::vector<int>> ConnectedComponents(const TriangleMesh& mesh);

// Axis-aligned bounding box of the vertices that a face has, or of all where there is no face; empty for
// an empty mesh.
Eigen::AlignedBox3d BoundingBox(const TriangleMesh& mesh);

// Diagonal of BoundingBox; 0 for an empty mesh.
double BoundingDiagonal(const TriangleMesh& mesh);

}  // namespace burin
