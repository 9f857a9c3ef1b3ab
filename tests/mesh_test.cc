#include "core/mesh.h"

#include <gtest/gtest.h>

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
  const Adjacency neighbors = VertexNeighbors(Tetrahedron());
  for (int v = 0; v < 4; ++v) EXPECT_EQ(neighbors.Degree(v), 3);
  const Adjacency faces = VertexFaces(Tetrahedron());
  for (int v = 0; v < 4; ++v) EXPECT_EQ(faces.Degree(v), 3);
}

TEST(Mesh, NormalsPointOutward) {
  const TriangleMesh mesh = Tetrahedron();
  const auto normals = VertexNormals(mesh);
  const Eigen::Vector3d centre(0.25, 0.25, 0.25);
  for (int v = 0; v < 4; ++v) {
    EXPECT_NEAR(normals[v].norm(), 1.0, 1e-12);
    EXPECT_GT(normals[v].dot(mesh.vertices[v] - centre), 0);
  }
}

TEST(Mesh, OnlyOpenSurfacesHaveBoundary) {
  TriangleMesh mesh = Tetrahedron();
  for (char flag : BoundaryVertices(mesh)) EXPECT_FALSE(flag);
  mesh.faces.pop_back();
  const auto boundary = BoundaryVertices(mesh);
  EXPECT_TRUE(boundary[0] && boundary[2] && boundary[3]);
  EXPECT_FALSE(boundary[1]);
}

}  // namespace
}  // namespace burin
