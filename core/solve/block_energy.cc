#include "core/solve/block_energy.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <array>
#include <limits>
#include <numeric>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kBlockGrain = 1024;

double EnergyOf(const ceres::Problem& problem, ceres::ResidualBlockId id) {
  static thread_local std::vector<double*> values;
  static thread_local std::vector<double> residuals;
  const ceres::CostFunction* cost = problem.GetCostFunctionForResidualBlock(id);
  problem.GetParameterBlocksForResidualBlock(id, &values);
  residuals.resize(cost->num_residuals());
  if (!cost->Evaluate(values.data(), residuals.data(), nullptr)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  double squared = 0;
  for (const double residual : residuals) squared += residual * residual;
  const ceres::LossFunction* loss = problem.GetLossFunctionForResidualBlock(id);
  if (loss == nullptr) return 0.5 * squared;
  std::array<double, 3> rho;  // value and two derivatives
  loss->Evaluate(squared, rho.data());
  return 0.5 * rho[0];
}

}  // namespace

double BlockEnergy(const ceres::Problem& problem,
                   const std::vector<ceres::ResidualBlockId>& blocks) {
  std::vector<double> energies(blocks.size(), 0);
  ParallelFor(static_cast<int>(blocks.size()), kBlockGrain, [&](int begin, int end) {
    for (int b = begin; b < end; ++b) energies[b] = EnergyOf(problem, blocks[b]);
  });
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

}  // namespace burin
