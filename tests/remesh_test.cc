// Remeshing against exact truth: round, sharp and thin bodies, borders, and what must not change.
#include "core/mesh/remesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/mesh/closest_point.h"
#include "core/mesh/crossings.h"
#include "core/mesh/edge_lengths.h"
#include "core/mesh/mesh_check.h"
#include "core/support/parallel.h"
#include "tests/remesh_shapes.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

std::vector<double> Uniform(const TriangleMesh& mesh, double length) {
  return std::vector<double>(mesh.vertices.size(), length);
}

// What holds for every manifold input.
void ExpectSound(const TriangleMesh& before, const Remeshed& after) {
  const MeshReport was = CheckMesh(before);
  const MeshReport is = CheckMesh(after.mesh);
  EXPECT_EQ(is.nonmanifold_edge_count, 0);
  EXPECT_EQ(is.inconsistent_edge_count, 0);
  EXPECT_EQ(is.duplicate_face_count, 0);
  EXPECT_EQ(is.degenerate_face_count, 0);
  EXPECT_EQ(is.unreferenced_vertex_count, 0);
  EXPECT_EQ(is.component_count, was.component_count);
  EXPECT_EQ(is.boundary_edge_count == 0, was.boundary_edge_count == 0);
  EXPECT_EQ(EulerNumber(after.mesh), EulerNumber(before));
  ASSERT_EQ(after.on.size(), after.mesh.vertices.size());
  ASSERT_EQ(after.kept.size(), after.mesh.faces.size());
  for (const RemeshedVertex& on : after.on) {
    ASSERT_GE(on.facet, 0);
    ASSERT_LT(on.facet, static_cast<int>(before.faces.size()));
    EXPECT_GE(on.weights.minCoeff(), 0);
    EXPECT_NEAR(on.weights.sum(), 1, 1e-12);
  }
}

// No facet faces away from the input below it. What spans the rim of a plate may lie nearest to the other side: it
// is turned over where it faces away from the input at each of its corners, too.
void ExpectNothingTurnedOver(const TriangleMesh& before, const Remeshed& after) {
  const MeshDistance input(before);
  int turned = 0;
  for (int f = 0; f < static_cast<int>(after.mesh.faces.size()); ++f) {
    const Eigen::Vector3d normal = FaceAreaNormal(after.mesh, f);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    bool faces = false;
    for (const int v : after.mesh.faces[f]) {
      middle += after.mesh.vertices[v] / 3;
      faces |= normal.dot(FaceAreaNormal(before, after.on[v].facet)) > 0;
    }
    turned += static_cast<int>(!faces && normal.dot(input.Find(middle).normal) <= 0);
  }
  EXPECT_EQ(turned, 0);
}

void ExpectGoodShapes(const TriangleMesh& mesh, double quality, double angle) {
  const Shapes shapes = MeasureShapes(mesh);
  EXPECT_GE(shapes.mean_quality, quality);
  EXPECT_GE(shapes.smallest_angle, angle);
}

// The largest distance from the segment's points to the mesh.
double FarthestFrom(const MeshDistance& mesh, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& to) {
  double farthest = 0;
  for (int k = 0; k <= 400; ++k) {
    farthest = std::max(farthest, mesh.Find(from + k / 400.0 * (to - from)).distance);
  }
  return farthest;
}

TEST(Remesh, SphereKeepsRadiusAndVolumeAndGetsTheLength) {
  const double radius = 10;
  const TriangleMesh before = RoundSphere(radius, 5);  // edges of 0.3 to 0.6
  const Remeshed after = Remesh(before, Uniform(before, 1.5), {});
  ExpectSound(before, after);
  ExpectNothingTurnedOver(before, after);
  ExpectGoodShapes(after.mesh, 0.97, 25);
  EXPECT_NEAR(MeasureShapes(after.mesh).mean_edge, 1.5, 0.15);
  EXPECT_NEAR(Volume(after.mesh) / Volume(before), 1, 0.002);
  double farthest = 0;
  for (const Eigen::Vector3d& vertex : after.mesh.vertices) {
    farthest = std::max(farthest, std::abs(vertex.norm() - radius));
  }
  EXPECT_LT(farthest,
            0.045);  // the middle of a facet is 0.0375 below the sphere through its corners
}

TEST(Remesh, CubeKeepsItsEdgesAndCorners) {
  const TriangleMesh before = Box({40, 40, 40}, 0.5);
  const Remeshed after = Remesh(before, Uniform(before, 2), {});
  ExpectSound(before, after);
  ExpectNothingTurnedOver(before, after);
  ExpectGoodShapes(after.mesh, 0.95, 15);
  EXPECT_LT(after.mesh.faces.size(), before.faces.size() / 10);
  EXPECT_NEAR(Volume(after.mesh), 8000, 8);
  const MeshDistance surface(after.mesh);
  const MeshDistance truth(before);
  double farthest = 0;
  for (const Eigen::Vector3d& vertex : after.mesh.vertices) {
    farthest = std::max(farthest, truth.Find(vertex).distance);
  }
  EXPECT_LT(farthest, 0.1);
  farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector3d from = Eigen::Vector3d::Zero();
      from[(axis + 1) % 3] = 20 * (k % 2);
      from[(axis + 2) % 3] = 20 * (k / 2);
      farthest =
          std::max(farthest, FarthestFrom(surface, from, from + 20 * Eigen::Vector3d::Unit(axis)));
    }
  }
  EXPECT_LT(farthest, 0.2);
}

TEST(Remesh, NoisyCubeKeepsItsEdgesAsTheyWere) {
  TriangleMesh before = Box({40, 40, 40}, 0.5);
  std::mt19937 random(7);
  for (Eigen::Vector3d& vertex : before.vertices) {
    for (double& x : vertex) x += 0.06 * (static_cast<double>(random()) / 2147483648.0 - 1);
  }
  const Remeshed after = Remesh(before, Uniform(before, 2), {});
  ExpectSound(before, after);
  ExpectNothingTurnedOver(before, after);
  ExpectGoodShapes(after.mesh, 0.95, 15);
  EXPECT_NEAR(Volume(after.mesh), 8000, 8);
  const MeshDistance surface(after.mesh);
  double farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest =
        std::max(farthest, FarthestFrom(surface, {0, 0, 0}, 20 * Eigen::Vector3d::Unit(axis)));
  }
  EXPECT_LT(farthest, 0.15);
}

TEST(Remesh, NoIterationsMendSliversOnly) {
  TriangleMesh before = RoundSphere(10, 4);
  for (size_t f = 0; f < before.faces.size(); f += 37) {
    const Eigen::Vector3i& face = before.faces[f];
    before.vertices[face[0]] = 0.97 * before.vertices[face[1]] + 0.03 * before.vertices[face[2]];
  }
  EXPECT_GT(MeasureShapes(before).share_below_10, 0.05);
  RemeshOptions options;
  options.iterations = 0;
  const Remeshed after = Remesh(before, Uniform(before, 1), options);
  ExpectSound(before, after);
  EXPECT_EQ(after.split_count, 0);
  EXPECT_GT(after.mesh.faces.size(), before.faces.size() * 8 / 10);
  EXPECT_EQ(MeasureShapes(after.mesh).share_below_10, 0);
}

TEST(Remesh, CoarseCubeIsCutFine) {
  const TriangleMesh before = Box({1, 1, 1}, 20);
  const Remeshed after = Remesh(before, Uniform(before, 2), {});
  ExpectSound(before, after);
  ExpectNothingTurnedOver(before, after);
  ExpectGoodShapes(after.mesh, 0.95, 15);
  EXPECT_GT(after.mesh.faces.size(), 1000U);
  EXPECT_NEAR(Volume(after.mesh), 8000, 8);
}

TEST(Remesh, RodOfOneAndAHalfPixelsStaysRound) {
  const TriangleMesh before = Rod(1.5, 80, 12, 100);
  EdgeLengthOptions by_chord;
  by_chord.chord_px = 0.12;
  by_chord.max_px = 12;
  for (const EdgeLengthOptions& options : {EdgeLengthOptions(), by_chord}) {
    const std::vector<double> lengths = EdgeLengths(before, Uniform(before, 1), options);
    const Remeshed after = Remesh(before, lengths, {});
    ExpectSound(before, after);
    ExpectNothingTurnedOver(before, after);
    EXPECT_TRUE(CrossingFacets(after.mesh).empty());
    EXPECT_LT(MeasureShapes(after.mesh).share_below_10, 0.001);
    EXPECT_NEAR(Volume(after.mesh) / Volume(before), 1, 0.05);
    const MeshDistance surface(after.mesh);
    EXPECT_LT(FarthestFrom(surface, {0, 0, 0}, {0, 0, 80}), 1.8);
    EXPECT_LT(surface.Find({0, 0, 0}).distance, 0.3);
    EXPECT_LT(surface.Find({0, 0, 80}).distance, 0.3);
  }
}

TEST(Remesh, PlateOfOnePixelKeepsBothSides) {
  const TriangleMesh before = Box({40, 40, 1}, 1);
  const Remeshed after =
      Remesh(before, EdgeLengths(before, Uniform(before, 1), EdgeLengthOptions()), {});
  ExpectSound(before, after);
  ExpectNothingTurnedOver(before, after);
  EXPECT_TRUE(CrossingFacets(after.mesh).empty());
  EXPECT_NEAR(Volume(after.mesh), 1600, 80);
  EXPECT_LT(after.mesh.faces.size(), 1100U);
  const MeshDistance surface(after.mesh);
  for (const double z : {0.0, 1.0}) EXPECT_LT(surface.Find({20, 20, z}).distance, 0.05);
}

TEST(Remesh, CornerOfThreePlanesAndItsBorder) {
  // Three sides of a box that meet in a corner: border of six straight pieces.
  TriangleMesh before = Box({20, 20, 20}, 1);
  std::vector<Eigen::Vector3i> faces;
  for (const Eigen::Vector3i& face : before.faces) {
    Eigen::Vector3d largest = before.vertices[face[0]];
    for (const int v : face) largest = largest.cwiseMax(before.vertices[v]);
    if (largest.minCoeff() == 0) faces.push_back(face);
  }
  before.faces = faces;
  const Remeshed after = Remesh(before, Uniform(before, 3), {});
  ExpectSound(before, after);
  ExpectNothingTurnedOver(before, after);
  ExpectGoodShapes(after.mesh, 0.93, 12);
  EXPECT_NEAR(BorderLength(after.mesh), 120, 0.5);
  EXPECT_NEAR(Area(after.mesh), 1200, 4);
  const MeshDistance surface(after.mesh);
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(20, 0, 0), Eigen::Vector3d(20, 20, 0),
        Eigen::Vector3d(0, 20, 0), Eigen::Vector3d(0, 20, 20), Eigen::Vector3d(0, 0, 20),
        Eigen::Vector3d(20, 0, 20)}) {
    EXPECT_LT(surface.Find(corner).distance, 0.15) << corner.transpose();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(FarthestFrom(surface, {0, 0, 0}, 20 * Eigen::Vector3d::Unit(axis)), 0.2);
  }
}

TEST(Remesh, FlatSquareStaysTheSquare) {
  const TriangleMesh before = Plane(3, 10, 50);
  const Remeshed after = Remesh(before, Uniform(before, 1), {});
  ExpectSound(before, after);
  ExpectGoodShapes(after.mesh, 0.95, 20);
  EXPECT_NEAR(Area(after.mesh), 100, 0.05);
  EXPECT_NEAR(BorderLength(after.mesh), 40, 0.05);
  for (size_t v = 0; v < after.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d& vertex = after.mesh.vertices[v];
    EXPECT_NEAR(vertex.z(), 3, 1e-9);
    Eigen::Vector3d on = Eigen::Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      on += after.on[v].weights[c] * before.vertices[before.faces[after.on[v].facet][c]];
    }
    EXPECT_LT((on - vertex).norm(), 0.01);
  }
}

TEST(Remesh, RoundBorderKeepsItsRadius) {
  TriangleMesh before = Grid(60, 20, [](double, double) { return 0.0; });
  std::vector<Eigen::Vector3i> faces;
  for (const Eigen::Vector3i& face : before.faces) {
    double farthest = 0;
    for (const int v : face) {
      farthest = std::max(farthest, (before.vertices[v] - Eigen::Vector3d(10, 10, 0)).norm());
    }
    if (farthest < 9) faces.push_back(face);
  }
  before.faces = faces;
  // Onto the circle what is at the border.
  const std::vector<char> border = BoundaryVertices(before, VertexFaces(before));
  for (size_t v = 0; v < before.vertices.size(); ++v) {
    const Eigen::Vector3d offset = before.vertices[v] - Eigen::Vector3d(10, 10, 0);
    if (border[v] != 0) before.vertices[v] += (9 / offset.norm() - 1) * offset;
  }
  const Remeshed after = Remesh(before, Uniform(before, 1.2), {});
  ExpectSound(before, after);
  EXPECT_NEAR(BorderLength(after.mesh) / BorderLength(before), 1, 0.01);
  EXPECT_NEAR(Area(after.mesh) / Area(before), 1, 0.005);
}

TEST(Remesh, KeptFacetsStayAsTheyAre) {
  const TriangleMesh before = RoundSphere(10, 4);
  std::vector<char> keep(before.faces.size(), 0);
  for (size_t f = 0; f < before.faces.size(); ++f) {
    keep[f] = static_cast<char>(FaceAreaNormal(before, static_cast<int>(f)).z() > 0);
  }
  const Remeshed after = Remesh(before, Uniform(before, 2.5), {}, &keep);
  ExpectSound(before, after);
  std::vector<int> seen(before.faces.size(), 0);
  int new_count = 0;
  for (size_t f = 0; f < after.mesh.faces.size(); ++f) {
    const int input = after.kept[f];
    if (input < 0) {
      ++new_count;
      continue;
    }
    ++seen[input];
    for (int c = 0; c < 3; ++c) {
      const int v = after.mesh.faces[f][c];
      EXPECT_EQ(after.mesh.vertices[v], before.vertices[before.faces[input][c]]);
      const RemeshedVertex& on = after.on[v];
      EXPECT_EQ(on.weights.maxCoeff(), 1);
    }
  }
  for (size_t f = 0; f < keep.size(); ++f) EXPECT_EQ(seen[f], keep[f]) << f;
  EXPECT_GT(new_count, 100);
  EXPECT_LT(new_count, static_cast<int>(before.faces.size()) / 4);
}

TEST(Remesh, NonManifoldEdgeStays) {
  // Three walls on one line of 20 edges.
  TriangleMesh before;
  const int n = 20;
  for (int wall = 0; wall < 3; ++wall) {
    const double angle = 2 * M_PI * wall / 3;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    const auto vertex = [&](int along, int away) {
      return away == 0 ? along : (n + 1) * (1 + wall * n) + (away - 1) * (n + 1) + along;
    };
    for (int away = wall == 0 ? 0 : 1; away <= n; ++away) {
      for (int along = 0; along <= n; ++along) {
        before.vertices.push_back(0.5 * (away * out + along * Eigen::Vector3d::UnitZ()));
      }
    }
    for (int away = 0; away < n; ++away) {
      for (int along = 0; along < n; ++along) {
        before.faces.emplace_back(vertex(along, away), vertex(along, away + 1),
                                  vertex(along + 1, away + 1));
        before.faces.emplace_back(vertex(along, away), vertex(along + 1, away + 1),
                                  vertex(along + 1, away));
      }
    }
  }
  const Remeshed after = Remesh(before, Uniform(before, 1.5), {});
  EXPECT_EQ(CheckMesh(before).nonmanifold_edge_count, n);
  EXPECT_EQ(CheckMesh(after.mesh).nonmanifold_edge_count, n);
  EXPECT_EQ(CheckMesh(after.mesh).component_count, 1);
  EXPECT_LT(after.mesh.faces.size(), before.faces.size() / 2);
  EXPECT_NEAR(Area(after.mesh) / Area(before), 1, 0.005);
}

TEST(Remesh, SameForAnyNumberOfThreads) {
  const TriangleMesh before = Relief(40);
  const auto remeshed = [&](int threads) {
    const ThreadScope scope(threads);
    return Remesh(before, EdgeLengths(before, Uniform(before, 0.01), {}), {});
  };
  const Remeshed one = remeshed(1);
  const Remeshed four = remeshed(4);
  EXPECT_EQ(one.mesh.faces, four.mesh.faces);
  EXPECT_EQ(one.mesh.vertices, four.mesh.vertices);
  for (size_t v = 0; v < one.on.size(); ++v) {
    EXPECT_EQ(one.on[v].facet, four.on[v].facet);
    EXPECT_EQ(one.on[v].weights, four.on[v].weights);
  }
}

TEST(Remesh, NothingGivesNothing) {
  const Remeshed after = Remesh({}, {}, {});
  EXPECT_TRUE(after.mesh.vertices.empty());
  EXPECT_TRUE(after.mesh.faces.empty());
}

}  // namespace
}  // namespace burin
