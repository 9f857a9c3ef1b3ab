#include "core/mesh/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

namespace burin {
namespace {

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

TEST(Mesh, ClosedSurfaceHasCancellingAreaNormals) {
  const TriangleMesh mesh = Tetrahedron();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int f = 0; f < 4; ++f) sum += FaceAreaNormal(mesh, f);
  EXPECT_LT(sum.norm(), 1e-15);
}

TEST(Mesh, NeighboursOfATetrahedronAreAllOthers) {
  const Adjacency neighbors = VertexNeighbors(Tetrahedron(), VertexFaces(Tetrahedron()));
  for (int v = 0; v < 4; ++v) EXPECT_EQ(neighbors.Degree(v), 3);
  const Adjacency faces = VertexFaces(Tetrahedron());
  for (int v = 0; v < 4; ++v) EXPECT_EQ(faces.Degree(v), 3);
}

TEST(Mesh, NormalsPointOutward) {
  const TriangleMesh mesh = Tetrahedron();
  const auto normals = VertexNormals(mesh, VertexFaces(mesh));
  const Eigen::Vector3d centre(0.25, 0.25, 0.25);
  for (int v = 0; v < 4; ++v) {
    EXPECT_NEAR(normals[v].norm(), 1.0, 1e-12);
    EXPECT_GT(normals[v].dot(mesh.vertices[v] - centre), 0);
  }
}

TEST(Mesh, OnlyOpenSurfacesHaveBoundary) {
  TriangleMesh mesh = Tetrahedron();
  for (char flag : BoundaryVertices(mesh, VertexFaces(mesh))) EXPECT_FALSE(flag);
  mesh.faces.pop_back();
  const auto boundary = BoundaryVertices(mesh, VertexFaces(mesh));
  EXPECT_TRUE(boundary[0] && boundary[2] && boundary[3]);
  EXPECT_FALSE(boundary[1]);
}

// Open, branching and irregular.
TEST(Mesh, NeighbourhoodsAreThoseCountedOneByOne) {
  TriangleMesh mesh;
  mesh.vertices.resize(5000, Eigen::Vector3d::Zero());  // several grains of the parallel loop
  std::mt19937 random(7);
  for (int f = 0; f < 9000; ++f) {
    const int a = static_cast<int>(random() % 4990);
    mesh.faces.emplace_back(a, a + 1 + static_cast<int>(random() % 3),
                            a + 4 + static_cast<int>(random() % 3));
  }
  std::vector<std::set<int>> neighbors(mesh.vertices.size());
  std::vector<std::set<int>> faces(mesh.vertices.size());
  std::map<std::pair<int, int>, int> edges;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int a = mesh.faces[f][c];
      const int b = mesh.faces[f][(c + 1) % 3];
      faces[a].insert(static_cast<int>(f));
      neighbors[a].insert(b);
      neighbors[b].insert(a);
      ++edges[std::minmax(a, b)];
    }
  }
  std::vector<char> boundary(mesh.vertices.size(), 0);
  for (const auto& [edge, count] : edges) {
    if (count == 1) boundary[edge.first] = boundary[edge.second] = 1;
  }
  const Adjacency vertex_neighbors = VertexNeighbors(mesh, VertexFaces(mesh));
  const Adjacency vertex_faces = VertexFaces(mesh);
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) {
    EXPECT_EQ(std::vector<int>(vertex_neighbors.Begin(v), vertex_neighbors.End(v)),
              std::vector<int>(neighbors[v].begin(), neighbors[v].end()));
    EXPECT_EQ(std::vector<int>(vertex_faces.Begin(v), vertex_faces.End(v)),
              std::vector<int>(faces[v].begin(), faces[v].end()));
  }
  EXPECT_EQ(BoundaryVertices(mesh, VertexFaces(mesh)), boundary);
  EXPECT_GT(std::count(boundary.begin(), boundary.end(), 0), 10);
}

}  // namespace
}  // namespace burin
