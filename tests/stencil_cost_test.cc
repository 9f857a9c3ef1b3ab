// Null spaces and closed forms of the Laplacian stencils, and their residuals against autodiff-free
// sums.
#include "costs/stencil_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

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

}  // namespace
}  // namespace burin
