// Smoothness residuals: linear stencils on vertex positions, as blocks of the energy and as Ceres cost functions.
//
//   r(V) = s * (sum_k c_k V_k - b)   (3 residuals),   dr/dV_k = s * c_k * I_3
//
// With sum_k c_k = 0 the residual is invariant to translation. The umbrella stencil gives the vector
// from a vertex to its neighbours' mean: E_smooth of Romanoni & Matteucci's eq. 1 in least-squares form.
// The paper's umbrella *step* is not the gradient of its 1/2|r|^2; that gradient is L^T L V.
// Coefficients and s are constants of the round.
#pragma once

#include <ceres/cost_function.h>

#include <memory>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/solve/energy_blocks.h"

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

class StencilCost : public ceres::CostFunction {
 public:
  StencilCost(std::vector<double> coefficients, double scale,
              const Eigen::Vector3d& target = Eigen::Vector3d::Zero());
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  std::vector<double> coefficients_;  // already multiplied by the scale
  const Eigen::Vector3d offset_;      // -s * b
};

// The stencils of a round, one a block: energy 1/2 |r|^2. Its parameters are vertices, by their numbers.
class StencilBlocks : public EnergyBlocks {
 public:
  // `coefficients` of every entry of `vertices`, already multiplied by the stencil's s; b = 0. `positions` are the
  // vertices, read where an evaluation needs them; they outlive this.
  StencilBlocks(Adjacency vertices, std::vector<double> coefficients,
                const std::vector<Eigen::Vector3d>* positions);
  // b of block k becomes the stencil's value on `rest`, in place of 0.
  void SetRest(int k, const std::vector<Eigen::Vector3d>& rest);

  bool Evaluate(int k, const TangentDirections* directions, double* energy, double* gradient,
                double* curvature) const override;
  CostFunctions MakeCostFunctions() const override;

 private:
  Eigen::Vector3d Sum(int k, const std::vector<Eigen::Vector3d>& positions) const;

  std::vector<double> coefficients_;
  const std::vector<Eigen::Vector3d>* positions_;
  std::vector<Eigen::Vector3d> offsets_;  // -s * b; empty while all are 0
};

}  // namespace burin
