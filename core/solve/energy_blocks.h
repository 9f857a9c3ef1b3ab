// A part of a round's energy as a sum over small blocks, each of a few parameter blocks:
//
//   E = sum_k E_k(x_a, x_b, ...)
//
// A term knows of every block its energy, gradient and curvature. burin's own normal equations
// (core/solve/normal_equations.h) add these up as they are. For Ceres' minimisers, which want residuals r with
// E = 1/2 |r|^2 and their Jacobian, a term makes cost functions of it, when one of them is taken.
// A term that has only cost functions of Ceres hands those in (RoundEnergy::Add).
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <memory>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

// Of one parameter block: how it moves with the unknowns of the solve. For a constant block `columns` is 0.
struct TangentDirections {
  const double* plus;  // d block / d unknowns, size x columns, row-major
  int columns;
};

// A part of the energy for Ceres. `losses`: of each, null = none; empty when none has one. Whoever made this owns them.
struct CostFunctions {
  std::vector<std::unique_ptr<ceres::CostFunction>> costs;
  Adjacency parameters;  // of each, by their numbers in the RoundEnergy
  std::vector<ceres::LossFunction*> losses;
};

class CameraCoupling;

class EnergyBlocks {
 public:
  virtual ~EnergyBlocks() = default;
  EnergyBlocks(const EnergyBlocks&) = delete;
  EnergyBlocks& operator=(const EnergyBlocks&) = delete;

  int size() const { return static_cast<int>(parameters_.start.size()) - 1; }
  // Of every block its parameter blocks, by their numbers in the RoundEnergy; none twice.
  const Adjacency& parameters() const { return parameters_; }

  // Called on one thread before blocks are evaluated at new values; `curvature`: it will be asked for.
  virtual void Prepare(bool curvature) { (void)curvature; }

  // E_k at the current values of the parameters, and where they are not null its gradient (m entries) and
  // the upper triangle of its curvature (m x m, row-major; what is below the diagonal is left as it is), a
  // positive semi-definite matrix. m is the sum of all columns. From any number of threads. False when
  // there is no finite value here.
  virtual bool Evaluate(int k, const TangentDirections* directions, double* energy,
                        double* gradient, double* curvature) const = 0;

  // Curvature between vertices and cameras beside that of the blocks, as of the last Prepare() with curvature; null =
  // none. A block itself has either cameras or others among its parameters. That of all blocks together stays
  // positive semi-definite.
  virtual const CameraCoupling* Coupling() const { return nullptr; }

  // Cost functions with the same sum, gradient and curvature: of these blocks or, where another cut suits residuals
  // better, of others. This outlives them.
  virtual CostFunctions MakeCostFunctions() const = 0;

 protected:
  explicit EnergyBlocks(Adjacency parameters) : parameters_(std::move(parameters)) {}

  Adjacency parameters_;
};

}  // namespace burin
