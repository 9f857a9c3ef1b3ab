// Null spaces and closed forms of the Laplacian stencils, and their residuals against autodiff-free
// sums.
#include "costs/stencil_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "tests/test_scene.h"

namespace burin {
namespace {

struct Surface {
  explicit Surface(double curvature) {
    test::AppendGrid(&mesh, 6, 0, 0, 1.0,
                     [curvature](double x, double y) { return curvature * (x * x + y * y); });
    neighbors = VertexNeighbors(mesh, VertexFaces(mesh));
    faces = VertexFaces(mesh);
    boundary = BoundaryVertices(mesh, VertexFaces(mesh));
  }
  TriangleMesh mesh;
  Adjacency neighbors;
  Adjacency faces;
  std::vector<char> boundary;
};

constexpr int kMiddle = 3 * 7 + 3;

TEST(Stencil, CoefficientsSumToZero) {
  const Surface surface(0.3);
  for (int v = 0; v < 49; ++v) {
    for (const Stencil& stencil :
         {UmbrellaStencil(v, surface.neighbors, surface.boundary),
          BiLaplacianStencil(v, surface.neighbors, surface.boundary),
          CotangentStencil(v, surface.mesh, surface.neighbors, surface.faces, surface.boundary)}) {
      const double sum =
          std::accumulate(stencil.coefficient.begin(), stencil.coefficient.end(), 0.0);
      EXPECT_NEAR(sum, 0, 1e-14);
    }
  }
}

// The stencil's value.
Eigen::Vector3d Apply(const Stencil& stencil, const std::vector<Eigen::Vector3d>& positions) {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < stencil.vertex.size(); ++k) {
    value += stencil.coefficient[k] * positions[stencil.vertex[k]];
  }
  return value;
}

TEST(Stencil, PlanesAreFlatInside) {
  const Surface surface(0);
  for (int v = 0; v < 49; ++v) {
    if (surface.boundary[v] != 0) continue;
    const Eigen::Vector3d umbrella =
        Apply(UmbrellaStencil(v, surface.neighbors, surface.boundary), surface.mesh.vertices);
    EXPECT_LT(umbrella.norm(), 1e-15);  // the grid's six neighbours are point-symmetric
    EXPECT_LT(
        Apply(CotangentStencil(v, surface.mesh, surface.neighbors, surface.faces, surface.boundary),
              surface.mesh.vertices)
            .norm(),
        1e-15);
  }
}

TEST(Stencil, ParaboloidHasConstantUmbrellaAndNoBiLaplacian) {
  const Surface surface(0.5);
  // Neighbours at (+-h, 0), (0, +-h), (h, h), (-h, -h): the mean of z - z0 is 0.5 * 8 h^2 / 6.
  const double h = 1.0 / 3;
  const Eigen::Vector3d umbrella =
      Apply(UmbrellaStencil(kMiddle, surface.neighbors, surface.boundary), surface.mesh.vertices);
  EXPECT_NEAR(umbrella.z(), 0.5 * 8 * h * h / 6, 1e-14);
  const Eigen::Vector3d bilaplacian = Apply(
      BiLaplacianStencil(kMiddle, surface.neighbors, surface.boundary), surface.mesh.vertices);
  EXPECT_LT(bilaplacian.norm(), 1e-14);
}

TEST(Stencil, BordersAreSmoothedAlongThemselvesOnly) {
  const Surface surface(0);
  const Stencil stencil = UmbrellaStencil(3, surface.neighbors, surface.boundary);
  EXPECT_EQ(stencil.vertex.size(), 3u);
  for (int vertex : stencil.vertex) EXPECT_TRUE(surface.boundary[vertex]);
  EXPECT_LT(Apply(stencil, surface.mesh.vertices).norm(), 1e-15);
}

TEST(StencilCost, ResidualAndJacobianAgree) {
  const StencilCost cost({-1, 0.5, 0.5}, 2.0, Eigen::Vector3d(0.1, 0.2, 0.3));
  Eigen::Vector3d points[3] = {{1, 2, 3}, {2, 0, 1}, {0, 1, -1}};
  const double* parameters[3] = {points[0].data(), points[1].data(), points[2].data()};
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> jacobian[3];
  double* jacobians[3] = {jacobian[0].data(), jacobian[1].data(), jacobian[2].data()};
  Eigen::Vector3d residual;
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
  const Eigen::Vector3d expected =
      2 * (-points[0] + 0.5 * points[1] + 0.5 * points[2] - Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT((residual - expected).norm(), 1e-15);
  for (int k = 0; k < 3; ++k) {
    for (int c = 0; c < 3; ++c) {
      const double before = points[k][c];
      points[k][c] = before + 1;
      Eigen::Vector3d moved;
      cost.Evaluate(parameters, moved.data(), nullptr);
      points[k][c] = before;
      EXPECT_LT((moved - residual - jacobian[k].col(c)).norm(), 1e-14);
    }
  }
}

// Stencils as blocks: what follows from the cost functions, with one that keeps its shape.
TEST(StencilBlocks, AreTheCostFunctions) {
  std::vector<Eigen::Vector3d> points = {{1, 2, 3}, {2, 0, 1}, {0, 1, -1}};
  const std::vector<Eigen::Vector3d> rest = {{1, 1, 1}, {0, 2, 0}, {3, 1, 0}};
  StencilBlocks blocks({{0, 3, 5}, {0, 1, 2, 2, 0}}, {-2, 1, 1, 0.5, -0.5}, &points);
  ASSERT_EQ(blocks.size(), 2);
  blocks.SetRest(1, rest);
  const std::vector<std::unique_ptr<ceres::CostFunction>> costs = blocks.MakeCostFunctions().costs;
  const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Eigen::Vector3d line(0.6, 0, 0.8);
  for (int k = 0; k < 2; ++k) {
    const int count = blocks.parameters().Degree(k);
    std::vector<const double*> parameters;
    std::vector<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> jacobian(count);
    std::vector<double*> jacobians;
    for (int p = 0; p < count; ++p) {
      parameters.push_back(points[blocks.parameters().Begin(k)[p]].data());
      jacobians.push_back(jacobian[p].data());
    }
    Eigen::Vector3d residual;
    ASSERT_TRUE(costs[k]->Evaluate(parameters.data(), residual.data(), jacobians.data()));
    if (k == 1) {
      EXPECT_LT((residual - 0.5 * (points[2] - points[0] - rest[2] + rest[0])).norm(), 1e-15);
    }
    // The first moves on a line, the second everywhere, a third not at all.
    std::vector<TangentDirections> directions = {{line.data(), 1}, {identity, 3}, {nullptr, 0}};
    Eigen::Matrix<double, 3, 4> moves;
    moves << jacobian[0] * line, jacobian[1];
    double energy = 0;
    Eigen::Vector4d gradient;
    Eigen::Matrix<double, 4, 4, Eigen::RowMajor> curvature;
    ASSERT_TRUE(blocks.Evaluate(k, directions.data(), &energy, gradient.data(), curvature.data()));
    EXPECT_NEAR(energy, residual.squaredNorm() / 2, 1e-14);
    EXPECT_LT((gradient - moves.transpose() * residual).norm(), 1e-14);
    const Eigen::Matrix4d full = curvature.selfadjointView<Eigen::Upper>();
    EXPECT_LT((full - moves.transpose() * moves).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace burin
