// What files keep apart is joined on reading, and polygons are cut without folding: closed forms on small shapes.
#include "core/mesh/weld.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "core/mesh/mesh_check.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/polygon_cut.h"
#include "tests/colmap_testing.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

using testing::HasSubstr;

// Every face with vertices of its own, as STL has it.
TriangleMesh Soup(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const int first = static_cast<int>(soup.vertices.size());
    for (const int v : face) soup.vertices.push_back(mesh.vertices[v]);
    soup.faces.emplace_back(first, first + 1, first + 2);
  }
  return soup;
}

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

TEST(Weld, SoupBecomesTheClosedSurfaceThatItWas) {
  TriangleMesh soup = Soup(Tetrahedron());
  EXPECT_EQ(WeldSeams(&soup), 8);
  const MeshReport report = CheckMesh(soup);
  EXPECT_EQ(report.vertex_count, 4);
  EXPECT_EQ(report.boundary_edge_count, 0);
  EXPECT_EQ(report.nonmanifold_edge_count, 0);
  EXPECT_EQ(WeldSeams(&soup), 0);
}

// A soup in which every facet is there twice.
TEST(Weld, DoubledFacetsGoBeforeSeamsAreWelded) {
  TriangleMesh twice = Tetrahedron();
  twice.faces.insert(twice.faces.end(), twice.faces.begin(), twice.faces.begin() + 4);
  TriangleMesh soup = Soup(twice);
  EXPECT_EQ(DropDuplicateFaces(&soup), 4);
  WeldSeams(&soup);
  EXPECT_EQ(CheckMesh(soup).boundary_edge_count, 0);
}

TEST(Weld, VerticesThatOnlyTouchStayTwo) {
  // Two triangles that touch with a corner, each with its own vertex there.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}};
  mesh.faces = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(WeldSeams(&mesh), 0);
  EXPECT_EQ(mesh.vertices.size(), 6U);
}

TEST(Weld, MakesNoEdgeOfThreeFaces) {
  // A T of three strips that meet in the edge from (0,0,0) to (0,1,0), each with its own vertices.
  TriangleMesh mesh;
  for (const Eigen::Vector3d& out :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 0, 1)}) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(),
                         {{0, 0, 0}, {0, 1, 0}, out, out + Eigen::Vector3d(0, 1, 0)});
    mesh.faces.emplace_back(first, first + 1, first + 2);
    mesh.faces.emplace_back(first + 1, first + 3, first + 2);
  }
  EXPECT_EQ(WeldSeams(&mesh), 0);
  TriangleMesh soup = Soup(mesh);
  EXPECT_GT(WeldSeams(&soup), 0);
  EXPECT_EQ(CheckMesh(soup).nonmanifold_edge_count, 0);
}

// Two closed bodies that share an edge keep the surfaces that they had.
TEST(Weld, SoupsThatTouchAlongAnEdge) {
  TriangleMesh two = Tetrahedron();
  const TriangleMesh one = Tetrahedron();
  for (const Eigen::Vector3d& vertex : one.vertices) {
    two.vertices.push_back(Eigen::Vector3d(-vertex.x(), -vertex.y(), vertex.z()));
  }
  for (const Eigen::Vector3i& face : one.faces) {
    two.faces.push_back(face + Eigen::Vector3i::Constant(4));
  }
  TriangleMesh soup = Soup(two);
  WeldSeams(&soup);
  const MeshReport report = CheckMesh(soup);
  EXPECT_EQ(report.nonmanifold_edge_count, 0);
  EXPECT_EQ(report.face_count, 8);
}

TEST(Weld, ReadingCountsAndWeldsASeam) {
  const TempFolder folder;
  // Two triangles of a square with the diagonal's vertices doubled, and the first of them twice.
  WriteBytes(
      folder.path() / "m.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 -0.0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\nf 2 3 1\n");
  MeshReport report;
  const TriangleMesh mesh = ReadMesh(folder.path() / "m.obj", &report);
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.faces.size(), 2U);
  EXPECT_EQ(report.boundary_edge_count, 4);
  EXPECT_THAT(report.Brief(), HasSubstr("1 duplicate faces"));
  EXPECT_THAT(report.Brief(), HasSubstr("2 vertices welded"));
}

double Area(const std::vector<Eigen::Vector3d>& corners, const Eigen::Vector3i& t,
            const Eigen::Vector3d& normal) {
  return 0.5 * (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).dot(normal);
}

TEST(CutPolygon, ConvexOnesAreFans) {
  EXPECT_EQ(CutPolygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}),
            (std::vector<Eigen::Vector3i>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(CutPolygon, AreasAddUpAndNoTriangleIsTurned) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> radius(0.2, 2);
  for (int trial = 0; trial < 200; ++trial) {
    // A star around the origin in a tilted plane.
    const int count = 4 + trial % 20;
    const Eigen::Matrix3d tilt =
        Eigen::AngleAxisd(trial, Eigen::Vector3d(1, 2, trial).normalized()).matrix();
    std::vector<Eigen::Vector3d> corners;
    double area = 0;
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * EIGEN_PI * k / count;
      const double r = radius(random);
      corners.push_back(tilt * Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0) +
                        Eigen::Vector3d(5, 6, 7));
    }
    const Eigen::Vector3d normal = tilt.col(2);
    for (int k = 0; k < count; ++k) {
      area += 0.5 * (corners[k] - Eigen::Vector3d(5, 6, 7))
                        .cross(corners[(k + 1) % count] - Eigen::Vector3d(5, 6, 7))
                        .dot(normal);
    }
    const std::vector<Eigen::Vector3i> triangles = CutPolygon(corners);
    ASSERT_EQ(triangles.size(), corners.size() - 2);
    double sum = 0;
    for (const Eigen::Vector3i& triangle : triangles) {
      EXPECT_GT(Area(corners, triangle, normal), -1e-12) << trial;
      sum += Area(corners, triangle, normal);
    }
    EXPECT_NEAR(sum, area, 1e-9) << trial;
  }
}

TEST(CutPolygon, ReadingAnLKeepsItsArea) {
  const TempFolder folder;
  WriteBytes(folder.path() / "l.obj",
             "v 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4 5 6\n");
  const TriangleMesh mesh = ReadMesh(folder.path() / "l.obj");
  double area = 0;
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f) {
    EXPECT_GT(FaceAreaNormal(mesh, f).z(), 0);
    area += FaceAreaNormal(mesh, f).z() / 2;
  }
  EXPECT_NEAR(area, 3, 1e-12);
}

}  // namespace
}  // namespace burin
