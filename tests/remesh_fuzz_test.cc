// Remeshing of surfaces that nobody would wish for: noise, holes, needles, facets without area, non-manifold
// vertices, soups. No crash, manifold in, manifold out, volume and borders kept, nothing turned over.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "core/mesh/closest_point.h"
#include "core/mesh/manifold_cut.h"
#include "core/mesh/mesh_check.h"
#include "core/mesh/remesh.h"
#include "tests/remesh_shapes.h"

namespace burin {
namespace {

using Random = std::mt19937;

double Uniform(Random* random, double low, double high) {
  return low + (high - low) * static_cast<double>((*random)()) / 4294967296.0;
}

int Below(Random* random, size_t count) { return static_cast<int>((*random)() % count); }

// One vertex for each fan of facets.
TriangleMesh Cut(const TriangleMesh& mesh) {
  const std::vector<int> label = LabelCorners(mesh);
  TriangleMesh cut;
  std::vector<int> vertex(label.size(), -1);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (RepeatsVertex(mesh.faces[f])) continue;
    Eigen::Vector3i face;
    for (int c = 0; c < 3; ++c) {
      int& v = vertex[label[3 * f + c]];
      if (v < 0) {
        v = static_cast<int>(cut.vertices.size());
        cut.vertices.push_back(mesh.vertices[mesh.faces[f][c]]);
      }
      face[c] = v;
    }
    cut.faces.push_back(face);
  }
  return cut;
}

void MakeHoles(Random* random, int count, TriangleMesh* mesh) {
  for (int k = 0; k < count; ++k) {
    mesh->faces.erase(mesh->faces.begin() + Below(random, mesh->faces.size()));
  }
}

void MakeNoise(Random* random, double size, TriangleMesh* mesh) {
  for (Eigen::Vector3d& vertex : mesh->vertices) {
    for (double& x : vertex) x += Uniform(random, -size, size);
  }
}

// Vertices moved onto, or almost onto, a neighbour, or onto the line between two.
void MakeNeedles(Random* random, int count, TriangleMesh* mesh) {
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3i& face = mesh->faces[Below(random, mesh->faces.size())];
    const Eigen::Vector3d& b = mesh->vertices[face[1]];
    const Eigen::Vector3d& c = mesh->vertices[face[2]];
    const double ts[] = {0, 1e-9, 1e-3, 0.5};
    mesh->vertices[face[0]] = b + ts[Below(random, 4)] * (c - b);
  }
}

std::vector<double> RandomLengths(Random* random, const TriangleMesh& mesh) {
  const double length = Uniform(random, 0.05, 0.4);
  const double slope = Uniform(random, 0, 0.2);
  std::vector<double> lengths;
  for (const Eigen::Vector3d& v : mesh.vertices)
    lengths.push_back(length + slope * std::abs(v.x()));
  return lengths;
}

void ExpectManifold(const TriangleMesh& before, const Remeshed& after) {
  const MeshReport report = CheckMesh(after.mesh);
  EXPECT_EQ(report.nonmanifold_edge_count, 0);
  EXPECT_EQ(report.inconsistent_edge_count, 0);
  EXPECT_EQ(report.unreferenced_vertex_count, 0);
  EXPECT_EQ(report.component_count, CheckMesh(before).component_count);
  EXPECT_EQ(report.boundary_edge_count == 0, CheckMesh(before).boundary_edge_count == 0);
  EXPECT_EQ(EulerNumber(after.mesh), EulerNumber(before));
  EXPECT_EQ(Cut(after.mesh).vertices.size(), after.mesh.vertices.size());
  for (const Eigen::Vector3d& vertex : after.mesh.vertices) EXPECT_TRUE(vertex.allFinite());
}

int CountTurnedOver(const TriangleMesh& before, const TriangleMesh& after) {
  const MeshDistance input(before);
  int count = 0;
  for (int f = 0; f < static_cast<int>(after.faces.size()); ++f) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int v : after.faces[f]) middle += after.vertices[v] / 3;
    const Eigen::Vector3d normal = input.Find(middle).normal;
    count += static_cast<int>(FaceAreaNormal(after, f).dot(normal) < 0);
  }
  return count;
}

TEST(RemeshFuzz, ClosedSurfacesKeepTheirVolume) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    TriangleMesh mesh = seed % 2 == 0 ? RoundSphere(1, 4) : Box({20, 14, 8}, 0.07);
    MakeNoise(&random, Uniform(&random, 0, 0.008), &mesh);
    if (seed % 3 == 0) MakeNeedles(&random, 20, &mesh);
    const Remeshed after = Remesh(mesh, RandomLengths(&random, mesh), {});
    ExpectManifold(mesh, after);
    EXPECT_NEAR(Volume(after.mesh) / Volume(mesh), 1, 0.03);
    EXPECT_EQ(CountTurnedOver(mesh, after.mesh), 0);
    EXPECT_LT(MeasureShapes(after.mesh).share_below_10, 0.01);
  }
}

TEST(RemeshFuzz, BordersStay) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    TriangleMesh mesh = Relief(24);
    MakeNoise(&random, Uniform(&random, 0, 0.004), &mesh);
    MakeHoles(&random, 1 + Below(&random, 60), &mesh);
    const TriangleMesh cut = Cut(mesh);
    const double length = Uniform(&random, 0.04, 0.16);
    const Remeshed after = Remesh(cut, std::vector<double>(cut.vertices.size(), length), {});
    ExpectManifold(cut, after);
    EXPECT_NEAR(Area(after.mesh) / Area(cut), 1, 0.03);
    EXPECT_EQ(CountTurnedOver(cut, after.mesh), 0);
    // Teeth are as long as the edges of the input, 0.04.
    const MeshDistance surface(after.mesh);
    const std::vector<char> border = BoundaryVertices(cut, VertexFaces(cut));
    double farthest = 0;
    for (size_t v = 0; v < border.size(); ++v) {
      if (border[v] != 0) farthest = std::max(farthest, surface.Find(cut.vertices[v]).distance);
    }
    EXPECT_LT(farthest, 0.04 + 0.1 * length);
  }
}

TEST(RemeshFuzz, BadSurfacesStayManifold) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    TriangleMesh mesh = seed % 2 == 0 ? Relief(16) : RoundSphere(1, 3);
    MakeNoise(&random, Uniform(&random, 0, 0.2), &mesh);
    MakeNeedles(&random, Below(&random, 100), &mesh);
    MakeHoles(&random, Below(&random, 100), &mesh);
    const TriangleMesh cut = Cut(mesh);
    ExpectManifold(cut, Remesh(cut, RandomLengths(&random, cut), {}));
  }
}

TEST(RemeshFuzz, SoupsAndTinyBodies) {
  int manifold_count = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    TriangleMesh mesh;
    const int vertex_count = 4 + Below(&random, 20);
    for (int v = 0; v < vertex_count; ++v) {
      mesh.vertices.emplace_back(Uniform(&random, 0, 1), Uniform(&random, 0, 1),
                                 Uniform(&random, 0, 1));
    }
    const int face_count = 1 + Below(&random, 40);
    for (int f = 0; f < face_count; ++f) {
      mesh.faces.emplace_back(Below(&random, vertex_count), Below(&random, vertex_count),
                              Below(&random, vertex_count));
    }
    const Remeshed soup = Remesh(mesh, RandomLengths(&random, mesh), {});
    EXPECT_EQ(CheckMesh(soup.mesh).unreferenced_vertex_count, 0);
    EXPECT_LE(CheckMesh(soup.mesh).nonmanifold_edge_count, CheckMesh(mesh).nonmanifold_edge_count);
    const TriangleMesh cut = Cut(mesh);
    const Remeshed after = Remesh(cut, RandomLengths(&random, cut), {});
    // A fan may come twice to an edge where it was cut: such an edge stays.
    const MeshReport report = CheckMesh(cut);
    if (report.nonmanifold_edge_count == 0 && report.inconsistent_edge_count == 0) {
      ++manifold_count;
      ExpectManifold(cut, after);
    }
  }
  EXPECT_GT(manifold_count, 100);
  // A tetrahedron far smaller than the edges wanted stays one.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Remeshed after = Remesh(mesh, std::vector<double>(4, 50.0), {});
  ExpectManifold(mesh, after);
  EXPECT_EQ(after.mesh.faces.size(), 4U);
  EXPECT_GT(Volume(after.mesh), 0.1);
}

}  // namespace
}  // namespace burin
