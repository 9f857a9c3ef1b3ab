// Smoothness residuals: a linear stencil on vertex positions as one Ceres cost function.
//
//   r(V) = s * (sum_k c_k V_k - b)   (3 residuals),   dr/dV_k = s * c_k * I_3
//
// With sum_k c_k = 0 the residual is invariant to translation. The umbrella stencil gives the vector
// from a vertex to its neighbours' mean: E_smooth of Romanoni & Matteucci's eq. 1 in least-squares form.
// The paper's umbrella *step* is not the gradient of its 1/2|r|^2; that gradient is L^T L V.
// Coefficients and s are constants of the round.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/solve/tangent_cost.h"

namespace burin {

// sum_k coefficient[k] * V[vertex[k]]
struct Stencil {
  std::vector<int> vertex;
  std::vector<double> coefficient;
};

// V_v -> mean of its neighbours minus V_v. A boundary vertex uses its boundary neighbours only, so
// that open borders are smoothed along themselves and not pulled inward. Empty when v has no faces.
Stencil UmbrellaStencil(int v, const Adjacency& neighbors, const std::vector<char>& boundary);

// The umbrella of umbrellas, L L V at v: zero for surfaces whose umbrella is linear over the mesh.
Stencil BiLaplacianStencil(int v, const Adjacency& neighbors, const std::vector<char>& boundary);

// Cotangent weights (half the sum of the cotangents of the angles opposite each edge, negative ones
// clamped to zero) normalised to sum 1, taken from `mesh` and then held constant. Zero tangential
// part on planar meshes with acute angles. Boundary vertices as in UmbrellaStencil.
Stencil CotangentStencil(int v, const TriangleMesh& mesh, const Adjacency& neighbors,
                         const Adjacency& faces, const std::vector<char>& boundary);

// The stencil's value on given positions.
Eigen::Vector3d Apply(const Stencil& stencil, const std::vector<Eigen::Vector3d>& positions);

class StencilCost : public TangentCost {
 public:
  StencilCost(std::vector<double> coefficients, double scale,
              const Eigen::Vector3d& target = Eigen::Vector3d::Zero());
  void SetTarget(const Eigen::Vector3d& target);  // b
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
  bool EvaluateTangent(double const* const* parameters, const TangentDirections* directions,
                       double* cost, double* gradient, double* curvature) const override;

 private:
  Eigen::Vector3d Residual(double const* const* parameters) const;

  std::vector<double> coefficients_;  // already multiplied by the scale
  const double scale_;
  Eigen::Vector3d offset_;  // -s * b
};

}  // namespace burin
