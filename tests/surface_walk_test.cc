// The walk to the nearest point against the exact nearest point, and where it must differ.
#include "core/mesh/surface_walk.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/mesh/closest_point.h"
#include "tests/remesh_shapes.h"

namespace burin {
namespace {

constexpr double kTrust = std::numeric_limits<double>::infinity();

Eigen::Vector3d Middle(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3i& face = mesh.faces[f];
  return (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
}

TEST(SurfaceWalk, FindsTheNearestPointOfASmoothSurface) {
  const TriangleMesh mesh = Relief(30);
  const SurfaceWalk walk(mesh);
  const MeshDistance exact(mesh);
  const int count = static_cast<int>(mesh.faces.size());
  for (int k = 0; k < 2000; ++k) {
    int facet = (k * 7919) % count;  // some way off
    const int below = std::min(facet + 40, count - 1);
    const Eigen::Vector3d query = Middle(mesh, below) + Eigen::Vector3d(0, 0, 0.02);
    const TrianglePoint found = walk.Find(query, kTrust, &facet);
    const SurfacePoint nearest = exact.Find(query);
    EXPECT_NEAR(std::sqrt(found.squared_distance), nearest.distance, 1e-12);
    const Eigen::Vector3d weights = walk.Weights(facet, found);
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (int c = 0; c < 3; ++c) point += weights[c] * mesh.vertices[mesh.faces[facet][c]];
    EXPECT_LT((point - found.point).norm(), 1e-12);
    EXPECT_NEAR(weights.sum(), 1, 1e-12);
    EXPECT_GE(weights.minCoeff(), 0);
  }
}

TEST(SurfaceWalk, StaysOnItsSheet) {
  const TriangleMesh plate = Box({20, 20, 1}, 1);  // a tenth as thick as the query is far
  const SurfaceWalk walk(plate);
  for (int f = 0; f < static_cast<int>(plate.faces.size()); ++f) {
    const Eigen::Vector3d middle = Middle(plate, f);
    if (middle.z() != 1 || (middle.head<2>().array() - 10).abs().maxCoeff() > 6) continue;
    int facet = f;
    const TrianglePoint found = walk.Find(middle - Eigen::Vector3d(0.4, 0.3, 0.9), kTrust, &facet);
    EXPECT_NEAR(found.point.z(), 1, 1e-12);  // the other side is nearer by 0.8
    EXPECT_NEAR(std::sqrt(found.squared_distance), 0.9, 1e-12);
  }
}

TEST(SurfaceWalk, GoesRoundSharpEdges) {
  // From the one side of a box' edge to a point on the other, at coordinates that make feet fall on the edge itself.
  const TriangleMesh box = Box({4, 4, 4}, 1);
  const SurfaceWalk walk(box);
  for (int f = 0; f < static_cast<int>(box.faces.size()); ++f) {
    if (Middle(box, f).x() != 0) continue;
    for (const double inside : {0.0, 1e-9, 0.01}) {
      int facet = f;
      const Eigen::Vector3d query(3.5, 1.3, inside);
      EXPECT_NEAR(std::sqrt(walk.Find(query, 0.1, &facet).squared_distance), inside, 1e-9);
      EXPECT_EQ(Middle(box, facet).z(), 0);
    }
  }
}

TEST(SurfaceWalk, FacetsWithoutAreaAreEdgesOrPoints) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 0}};
  mesh.faces = {{0, 1, 2}, {2, 3, 3}};
  const SurfaceWalk walk(mesh);
  int facet = 1;
  const TrianglePoint found = walk.Find({0.5, 1, 0}, kTrust, &facet);
  EXPECT_EQ(found.squared_distance, 1);
  EXPECT_EQ(facet, 0);
  const Eigen::Vector3d weights = walk.Weights(facet, found);
  EXPECT_NEAR((weights[1] + 2 * weights[2]), 0.5, 1e-12);
}

}  // namespace
}  // namespace burin
