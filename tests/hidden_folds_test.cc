#include "core/refine/hidden_folds.h"

#include <gtest/gtest.h>

#include "tests/test_scene.h"

namespace burin {
namespace {

// A grid of 9 x 9 vertices, flat but for a bulge of its inner 5 x 5, everything seen.
struct Bulge {
  Bulge() {
    test::AppendGrid(&mesh, 8, 0, 0, 1.0, [](double x, double y) {
      return std::max(std::abs(x), std::abs(y)) < 0.6 ? 0.4 - 0.1 * x : 0.0;
    });
    Update();
  }
  void Update() {
    context.neighbors = VertexNeighbors(mesh, VertexFaces(mesh));
    context.boundary = BoundaryVertices(mesh, VertexFaces(mesh));
    context.seen.assign(mesh.vertices.size(), 1);
    context.moves.assign(mesh.vertices.size(), 1);
    context.supported.assign(mesh.vertices.size(), 0);
  }
  bool Inside(const Eigen::Vector3d& p) const {
    return std::max(std::abs(p.x()), std::abs(p.y())) < 0.6;
  }
  void Hide() {
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      if (Inside(mesh.vertices[v])) context.seen[v] = 0;
    }
  }
  TriangleMesh mesh;
  RoundContext context;
};

TEST(HiddenFolds, BecomeTheMembraneOverTheirRim) {
  Bulge bulge;
  bulge.Hide();
  const TriangleMesh before = bulge.mesh;
  EXPECT_EQ(RelaxHiddenFolds(bulge.context, 500, &bulge.mesh), 25);
  for (size_t v = 0; v < before.vertices.size(); ++v) {
    if (bulge.context.seen[v] != 0) {
      EXPECT_EQ(bulge.mesh.vertices[v], before.vertices[v]);
    } else {
      EXPECT_NEAR(bulge.mesh.vertices[v].z(), 0, 1e-9);  // the rim is in the plane z = 0
    }
  }
}

TEST(HiddenFolds, WhatIsSeenOrNeverWasStays) {
  Bulge bulge;
  const TriangleMesh before = bulge.mesh;
  EXPECT_EQ(RelaxHiddenFolds(bulge.context, 10, &bulge.mesh), 0);
  bulge.Hide();
  bulge.context.moves = bulge.context.seen;
  EXPECT_EQ(RelaxHiddenFolds(bulge.context, 10, &bulge.mesh), 0);
  EXPECT_EQ(bulge.mesh.vertices, before.vertices);
}

TEST(HiddenFolds, BordersShortenAlongThemselves) {
  Bulge bulge;
  const int middle = 4;  // of the border row y = -1
  ASSERT_NE(bulge.context.boundary[middle], 0);
  bulge.mesh.vertices[middle] += Eigen::Vector3d(0.05, -0.3, 0.2);
  bulge.context.seen[middle] = 0;
  EXPECT_EQ(RelaxHiddenFolds(bulge.context, 1, &bulge.mesh), 1);
  EXPECT_NEAR((bulge.mesh.vertices[middle] - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-12);
}

TEST(HiddenFolds, PartsThatHangOnNothingStay) {
  Bulge bulge;
  const size_t first = bulge.mesh.vertices.size();
  test::AppendGrid(&bulge.mesh, 3, 5, 5, 1.0, [](double x, double y) { return x * y; });
  bulge.Update();
  bulge.Hide();
  for (size_t v = first; v < bulge.mesh.vertices.size(); ++v) bulge.context.seen[v] = 0;
  const TriangleMesh before = bulge.mesh;
  EXPECT_EQ(RelaxHiddenFolds(bulge.context, 10, &bulge.mesh), 25);
  for (size_t v = first; v < bulge.mesh.vertices.size(); ++v) {
    EXPECT_EQ(bulge.mesh.vertices[v], before.vertices[v]);
  }
}

}  // namespace
}  // namespace burin
