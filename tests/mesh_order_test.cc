#include "core/mesh/mesh_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/test_scene.h"

namespace burin {
namespace {

// A grid whose vertices and faces are in random order, and one vertex in no face.
TriangleMesh ShuffledGrid() {
  TriangleMesh grid;
  test::AppendGrid(&grid, 30, 0, 0, 1, [](double x, double y) { return x * y; });
  grid.vertices.emplace_back(5, 5, 5);
  test::Random random(3);
  const auto shuffled = [&random](size_t n) {
    std::vector<int> order(n);
    for (size_t k = 0; k < n; ++k) order[k] = static_cast<int>(k);
    for (size_t k = n; k > 1; --k) {
      const auto other = static_cast<size_t>((random.Uniform() + 1) / 2 * static_cast<double>(k));
      std::swap(order[k - 1], order[other]);
    }
    return order;
  };
  return Ordered(grid, {shuffled(grid.vertices.size()), shuffled(grid.faces.size())});
}

double MeanIndexDistance(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& face : mesh.faces) sum += face.maxCoeff() - face.minCoeff();
  return sum / static_cast<double>(mesh.faces.size());
}

TEST(MeshOrder, IsThePermutedMesh) {
  const TriangleMesh mesh = ShuffledGrid();
  const MeshOrder order = OrderAlongCurve(mesh);
  const TriangleMesh ordered = Ordered(mesh, order);
  ASSERT_EQ(ordered.vertices.size(), mesh.vertices.size());
  ASSERT_EQ(ordered.faces.size(), mesh.faces.size());
  for (size_t f = 0; f < ordered.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(ordered.vertices[ordered.faces[f][c]], mesh.vertices[mesh.faces[order.face[f]][c]]);
    }
  }
  std::vector<int> sorted = order.vertex;
  std::sort(sorted.begin(), sorted.end());
  for (size_t v = 0; v < sorted.size(); ++v) EXPECT_EQ(sorted[v], static_cast<int>(v));
}

TEST(MeshOrder, BringsNeighboursTogether) {
  const TriangleMesh mesh = ShuffledGrid();
  EXPECT_LT(MeanIndexDistance(Ordered(mesh, OrderAlongCurve(mesh))), 0.2 * MeanIndexDistance(mesh));
}

TEST(MeshOrder, RestoresVertices) {
  const TriangleMesh mesh = ShuffledGrid();
  const MeshOrder order = OrderAlongCurve(mesh);
  TriangleMesh moved = Ordered(mesh, order);
  for (Eigen::Vector3d& vertex : moved.vertices) vertex *= 2;
  TriangleMesh restored = mesh;
  RestoreVertices(moved, order, &restored);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_EQ(restored.vertices[v], 2 * mesh.vertices[v]);
  }
}

}  // namespace
}  // namespace burin
