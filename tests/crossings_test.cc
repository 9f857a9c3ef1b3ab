// Facets that cross against a brute force and closed forms, and what views see from behind.
#include "core/mesh/crossings.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <iterator>
#include <utility>

#include "core/support/parallel.h"
#include "core/visibility/back_faces.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// Facets of three vertices of their own.
TriangleMesh Soup(int facets, double size, uint64_t seed) {
  test::Random random(seed);
  TriangleMesh mesh;
  for (int f = 0; f < facets; ++f) {
    const Eigen::Vector3d center = random.Vector();
    for (int c = 0; c < 3; ++c) mesh.vertices.emplace_back(center + size * random.Vector());
    mesh.faces.emplace_back(3 * f, 3 * f + 1, 3 * f + 2);
  }
  return mesh;
}

// Where the line p + t (q - p) meets the plane of a triangle, in coordinates along its edges.
bool SegmentMeets(const TriangleMesh& mesh, int p, int q, const Eigen::Vector3i& face) {
  const Eigen::Vector3d& corner = mesh.vertices[face[0]];
  Eigen::Matrix3d system;
  system.col(0) = mesh.vertices[face[1]] - corner;
  system.col(1) = mesh.vertices[face[2]] - corner;
  system.col(2) = mesh.vertices[p] - mesh.vertices[q];
  const Eigen::Vector3d at = system.inverse() * (mesh.vertices[p] - corner);
  return at[0] > 0 && at[1] > 0 && at[0] + at[1] < 1 && at[2] > 0 && at[2] < 1;
}

std::vector<FacetPair> BruteForce(const TriangleMesh& mesh) {
  std::vector<FacetPair> pairs;
  const auto count = static_cast<int>(mesh.faces.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      bool cross = false;
      for (int c = 0; c < 3; ++c) {
        const int next = (c + 1) % 3;
        cross |= SegmentMeets(mesh, mesh.faces[a][c], mesh.faces[a][next], mesh.faces[b]) ||
                 SegmentMeets(mesh, mesh.faces[b][c], mesh.faces[b][next], mesh.faces[a]);
      }
      if (cross) pairs.push_back({a, b});
    }
  }
  return pairs;
}

TEST(Crossings, AreThoseOfBruteForceInAnyFrame) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    TriangleMesh mesh = Soup(200, 0.6, seed);
    const std::vector<FacetPair> expected = BruteForce(mesh);
    EXPECT_GT(expected.size(), 200U);
    EXPECT_EQ(CrossingFacets(mesh), expected);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(0.3, -0.7, 0.2, 0.5 + 0.1 * static_cast<double>(seed)).normalized();
    for (Eigen::Vector3d& vertex : mesh.vertices) {
      vertex = 40 * (turn * vertex) + Eigen::Vector3d(4e5, -5e6, 300);
    }
    EXPECT_EQ(CrossingFacets(mesh), expected);
  }
}

TEST(Crossings, AreTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = Soup(5000, 0.1, 9);
  std::vector<FacetPair> expected;
  for (const int threads : {1, 2, 4}) {
    const ThreadScope scope(threads);
    const std::vector<FacetPair> found = CrossingFacets(mesh);
    if (threads == 1) expected = found;
    EXPECT_EQ(found, expected);
  }
  EXPECT_GT(expected.size(), 1000U);
}

// Two facets: one in the plane z = 0, and one with the given corners.
bool Meet(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const TriangleMesh mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, a, b, c}, {{0, 1, 2}, {3, 4, 5}}};
  return !CrossingFacets(mesh).empty();
}

TEST(Crossings, TouchingIsNotCrossing) {
  const Eigen::Vector3d low(0.2, 0.2, -1);
  EXPECT_TRUE(Meet(low, {0.2, 0.2, 1}, {3, 3, 1}));
  EXPECT_FALSE(Meet(low, {0.2, 0.2, 0}, {3, 3, -1}));           // a corner in the plane
  EXPECT_FALSE(Meet(low, {0.2, 0.2, -0.5}, {3, 3, 1}));         // passes beside it
  EXPECT_FALSE(Meet({0.1, 0.1, 0}, {0.9, 0.9, 0}, {2, 0, 0}));  // within the plane
  // Through an edge, from above to below: else a line through an edge of a sheet would meet none of its facets.
  EXPECT_TRUE(Meet({0.5, 0, -1}, {0.5, 0, 1}, {0.5, -3, 1}));
}

// Sheets z = x and z = -x. The line where they meet runs through vertices, where nothing crosses, or through the
// middles of cells.
TEST(Crossings, OfTwoPlanesLieAlongALine) {
  constexpr int kCells = 8;
  for (const double shift : {0.0, 0.125}) {
    TriangleMesh mesh;
    test::AppendGrid(&mesh, kCells, 0, 0, 1, [&](double x, double) { return x - shift; });
    test::AppendGrid(&mesh, kCells, 0, 0, 1, [&](double x, double) { return shift - x; });
    EXPECT_EQ(CountFacets(CrossingFacets(mesh)), shift > 0 ? 4 * kCells : 0);
  }
}

TEST(Crossings, FacetsWithACommonVertexAreNotCompared) {
  const TriangleMesh fold = {{{0, 0, 0}, {1, -0.2, 0}, {1, 0.2, 0}, {1, 0, -1}, {1, 0, 1}},
                             {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_TRUE(CrossingFacets(fold).empty());
}

TEST(Crossings, AreFoundAnywhereOnAMotion) {
  const TriangleMesh start = Soup(300, 0.3, 3);
  const std::vector<Eigen::Vector3d> end = Soup(300, 0.3, 4).vertices;
  const CrossingSearch search(start.faces, start.vertices, end);
  std::vector<int> some;
  for (int f = 0; f < 300; f += 7) some.push_back(f);
  for (const double share : {0.0, 0.3, 1.0}) {
    TriangleMesh now = start;
    for (size_t v = 0; v < end.size(); ++v) now.vertices[v] += share * (end[v] - start.vertices[v]);
    const std::vector<FacetPair> all = search.Find(now.vertices);
    EXPECT_EQ(all, CrossingFacets(now));
    std::vector<FacetPair> expected;
    std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
                 [](const FacetPair& pair) { return pair.first % 7 == 0 || pair.second % 7 == 0; });
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(search.Find(now.vertices, &some), expected);
  }
}

TEST(Crossings, AMeshWithoutFacetsHasNone) { EXPECT_TRUE(CrossingFacets(TriangleMesh()).empty()); }

TEST(BackFaces, AreTheShareOfPixelsThatSeeThem) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 8, 0, 0, 1, [](double, double) { return 0.0; });
  const Camera front = test::LookAt({0, 0, 5}, {0, 0, 0}, 200, 160, 300);
  const Camera behind = test::LookAt({0, 0, -5}, {0, 0, 0}, 200, 160, 300);
  const BackFaces none = CountBackFaces(mesh, {front});
  EXPECT_EQ(none.pixels, 120 * 120);
  EXPECT_EQ(none.back, 0);
  const BackFaces half = CountBackFaces(mesh, {front, behind});
  EXPECT_EQ(half.pixels, 2 * none.pixels);
  EXPECT_EQ(half.back, none.pixels);
  // The quarter x, y > 0 turned over.
  for (Eigen::Vector3i& face : mesh.faces) {
    Eigen::Vector3d middle(0, 0, 0);
    for (const int v : face) middle += mesh.vertices[v];
    if (middle.x() > 0 && middle.y() > 0) std::swap(face[0], face[1]);
  }
  EXPECT_DOUBLE_EQ(CountBackFaces(mesh, {front}).Share(), 0.25);
  EXPECT_EQ(CountBackFaces(TriangleMesh(), {front}).Share(), 0);
}

}  // namespace
}  // namespace burin
