// Facets to be cut away, made to hang together (core/mesh/facet_labels.h), and the mesh without them.
#include "core/mesh/facet_labels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/mesh/smooth_rims.h"
#include "core/mesh/submesh.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

constexpr int kSide = 60;

// Squares of 6 px.
const TriangleMesh& Sheet() {
  static const auto* sheet = new TriangleMesh(Plane(0, 6.0 * kSide, kSide));
  return *sheet;
}

std::vector<double> Areas(const TriangleMesh& mesh) {
  std::vector<double> areas;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    areas.push_back(FaceAreaNormal(mesh, static_cast<int>(f)).norm() / 2);
  }
  return areas;
}

Eigen::Vector3d Middle(const TriangleMesh& mesh, size_t f) {
  const Eigen::Vector3i& face = mesh.faces[f];
  return (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
}

// Facets whose middle is chosen.
std::vector<char> Where(const std::function<bool(double x, double y)>& chosen) {
  std::vector<char> labels;
  for (size_t f = 0; f < Sheet().faces.size(); ++f) {
    const Eigen::Vector3d at = Middle(Sheet(), f);
    labels.push_back(chosen(at.x(), at.y()) ? 1 : 0);
  }
  return labels;
}

bool InSquare(double x, double y, double left, double top, double side) {
  return x > left && x < left + side && y > top && y < top + side;
}

std::vector<char> Smoothed(const std::vector<char>& cut) {
  return SmoothedLabels(Sheet(), FacetNeighbors(Sheet()), Areas(Sheet()), cut);
}

long Count(const std::vector<char>& labels) { return std::count(labels.begin(), labels.end(), 1); }

TEST(FacetLabels, NeighboursShareAnEdge) {
  const Adjacency neighbors = FacetNeighbors(Plane(0, 1, 2));
  int links = 0;
  for (int f = 0; f < 8; ++f) {
    EXPECT_TRUE(std::is_sorted(neighbors.Begin(f), neighbors.End(f)));
    links += neighbors.Degree(f);
  }
  EXPECT_EQ(links, 2 * 8);  // inner edges of 2 x 2 squares, both ways
  // Three facets on one edge are each other's neighbours.
  TriangleMesh book = {{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}},
                       {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}};
  EXPECT_EQ(FacetNeighbors(book).Degree(1), 2);
}

TEST(FacetLabels, HolesBelow200PixelsAreClosedAndLargerOnesStay) {
  EXPECT_EQ(Count(Smoothed(Where([](double x, double y) { return InSquare(x, y, 120, 120, 12); }))),
            0);
  const std::vector<char> large =
      Where([](double x, double y) { return InSquare(x, y, 120, 120, 60); });
  const std::vector<char> left = Smoothed(large);
  EXPECT_NEAR(static_cast<double>(Count(left)), static_cast<double>(Count(large)),
              0.1 * static_cast<double>(Count(large)));
}

TEST(FacetLabels, IslandsBelow200PixelsAreCutAndLargerOnesStay) {
  const auto island = [](double side) {
    return Where([side](double x, double y) {
      return InSquare(x, y, 60, 60, 240) && !InSquare(x, y, 150, 150, side);
    });
  };
  const std::vector<char> all =
      Smoothed(Where([](double x, double y) { return InSquare(x, y, 60, 60, 240); }));
  EXPECT_EQ(Smoothed(island(12)), all);
  const long kept = Count(all) - Count(Smoothed(island(60)));
  EXPECT_NEAR(static_cast<double>(kept), 200, 20);
}

// A part of its own is neither a hole nor an island, however small.
TEST(FacetLabels, SmallPartsKeepTheirLabel) {
  TriangleMesh mesh = Plane(0, 60, 10);
  test::AppendGrid(&mesh, 2, 200, 0, 5, [](double, double) { return 0; });
  for (const char label : {0, 1}) {
    std::vector<char> cut(mesh.faces.size(), label == 0 ? 1 : 0);
    std::fill(cut.end() - 8, cut.end(), label);
    EXPECT_EQ(SmoothedLabels(mesh, FacetNeighbors(mesh), Areas(mesh), cut), cut);
  }
}

double RimLength(const TriangleMesh& mesh, const std::vector<char>& cut) {
  const Adjacency neighbors = FacetNeighbors(mesh);
  double length = 0;
  for (size_t f = 0; f < cut.size(); ++f) {
    const auto at = static_cast<int>(f);
    for (const int* g = neighbors.Begin(at); g != neighbors.End(at); ++g) {
      if (cut[f] == 0 || cut[*g] != 0) continue;
      std::vector<int> common;
      for (const int v : mesh.faces[f]) {
        for (const int w : mesh.faces[*g]) {
          if (v == w) common.push_back(v);
        }
      }
      length += (mesh.vertices[common[0]] - mesh.vertices[common[1]]).norm();
    }
  }
  return length;
}

// A straight rim with every third facet near it wrong.
TEST(FacetLabels, RimsAreSmooth) {
  test::Random random(3);
  std::vector<char> cut = Where([](double x, double) { return x > 180; });
  const double straight = RimLength(Sheet(), cut);
  for (size_t f = 0; f < cut.size(); ++f) {
    const bool near = std::abs(Middle(Sheet(), f).x() - 180) < 12;
    if (random.Uniform() > 1 - 2.0 / 3 && near) cut[f] = cut[f] == 0 ? 1 : 0;
  }
  const double toothed = RimLength(Sheet(), cut);
  const std::vector<char> smooth = Smoothed(cut);
  EXPECT_GT(toothed, 2 * straight);
  EXPECT_LT(RimLength(Sheet(), smooth), 1.5 * straight);
}

// What is left is a manifold wherever the whole is, whatever is cut.
TEST(FacetLabels, WhatIsLeftNeverTouchesItselfAtAVertex) {
  for (int seed = 1; seed <= 5; ++seed) {
    test::Random random(seed);
    std::vector<Eigen::Vector2d> middles;
    middles.reserve(40);
    for (int k = 0; k < 40; ++k) {
      middles.emplace_back(180 + 180 * random.Uniform(), 180 + 180 * random.Uniform());
    }
    const std::vector<char> cut = Smoothed(Where([&](double x, double y) {
      return std::any_of(middles.begin(), middles.end(), [&](const Eigen::Vector2d& middle) {
        return (middle - Eigen::Vector2d(x, y)).norm() < 20;
      });
    }));
    ASSERT_GT(Count(cut), 100);
    for (const std::vector<int>& hole : FacetPatches(FacetNeighbors(Sheet()), cut)) {
      EXPECT_GE(18 * static_cast<double>(hole.size()), kLeastPatchPx);
    }
    std::vector<int> vertices;
    const TriangleMesh left = WithoutFacets(Sheet(), cut, &vertices);
    const Adjacency faces = VertexFaces(left);
    const Adjacency neighbors = VertexNeighbors(left, faces);
    for (size_t v = 0; v < left.vertices.size(); ++v) {
      const auto at = static_cast<int>(v);
      // A disc has as many neighbours as facets; half a disc one more; two halves two more.
      EXPECT_LE(neighbors.Degree(at), faces.Degree(at) + 1);
    }
  }
}

// The rim of a cut along x = 180 through a mesh whose vertices are off their places: its teeth go, its place stays.
TEST(SmoothRims, LosesTeethAndKeepsItsPlace) {
  TriangleMesh whole = Sheet();
  test::Random random(5);
  for (Eigen::Vector3d& vertex : whole.vertices) {
    vertex += 1.5 * Eigen::Vector3d(random.Uniform(), random.Uniform(), 0);
    vertex.z() = 0.001 * vertex.x() * vertex.x();
  }
  std::vector<char> cut;
  for (size_t f = 0; f < whole.faces.size(); ++f) cut.push_back(Middle(whole, f).x() > 180 ? 1 : 0);
  std::vector<int> vertices;
  const TriangleMesh toothed = WithoutFacets(whole, cut, &vertices);
  const std::vector<char> whole_boundary = BoundaryVertices(whole, VertexFaces(whole));
  const std::vector<char> boundary = BoundaryVertices(toothed, VertexFaces(toothed));
  std::vector<char> free;
  for (size_t v = 0; v < vertices.size(); ++v) free.push_back(whole_boundary[vertices[v]] == 0);
  TriangleMesh smooth = toothed;
  SmoothRims(free, &smooth);
  const auto spread = [&](const TriangleMesh& mesh, double* mean) {
    double sum = 0;
    double squares = 0;
    int count = 0;
    for (size_t v = 0; v < vertices.size(); ++v) {
      if (free[v] == 0 || boundary[v] == 0) continue;
      sum += mesh.vertices[v].x();
      squares += mesh.vertices[v].x() * mesh.vertices[v].x();
      ++count;
    }
    *mean = sum / count;
    return std::sqrt(squares / count - *mean * *mean);
  };
  double before = 0;
  double after = 0;
  const double toothed_spread = spread(toothed, &before);
  EXPECT_LT(spread(smooth, &after), 0.6 * toothed_spread);
  EXPECT_NEAR(after, before, 0.2);
  for (size_t v = 0; v < vertices.size(); ++v) {
    if (free[v] == 0 || boundary[v] == 0) {
      EXPECT_EQ(smooth.vertices[v], toothed.vertices[v]);
    }
    // Along the surface.
    EXPECT_NEAR(smooth.vertices[v].z(), 0.001 * std::pow(smooth.vertices[v].x(), 2), 0.05);
  }
  for (size_t f = 0; f < smooth.faces.size(); ++f) {
    const auto at = static_cast<int>(f);
    EXPECT_GT(FaceAreaNormal(smooth, at).dot(FaceAreaNormal(toothed, at)), 0);
  }
}

TEST(Submesh, HasTheFacetsThatAreLeftAndTheirVertices) {
  const TriangleMesh whole = Plane(0, 1, 2);
  std::vector<char> cut(8, 1);
  cut[3] = cut[6] = 0;
  std::vector<int> vertices;
  const TriangleMesh part = WithoutFacets(whole, cut, &vertices);
  ASSERT_EQ(part.faces.size(), 2U);
  ASSERT_EQ(part.vertices.size(), vertices.size());
  EXPECT_TRUE(std::is_sorted(vertices.begin(), vertices.end()));
  for (size_t v = 0; v < vertices.size(); ++v) {
    EXPECT_EQ(part.vertices[v], whole.vertices[vertices[v]]);
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(vertices[part.faces[0][c]], whole.faces[3][c]);
    EXPECT_EQ(vertices[part.faces[1][c]], whole.faces[6][c]);
  }
}

}  // namespace
}  // namespace burin
