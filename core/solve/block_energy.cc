#include "core/solve/block_energy.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <array>
#include <limits>
#include <numeric>

#include "core/solve/tangent_cost.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kBlockGrain = 1024;

double EnergyOf(const ceres::Problem& problem, ceres::ResidualBlockId id) {
  static thread_local std::vector<double*> values;
  static thread_local std::vector<double> residuals;
  const ceres::CostFunction* cost = problem.GetCostFunctionForResidualBlock(id);
  problem.GetParameterBlocksForResidualBlock(id, &values);
  const ceres::LossFunction* loss = problem.GetLossFunctionForResidualBlock(id);
  const auto* tangent_cost = loss == nullptr ? dynamic_cast<const TangentCost*>(cost) : nullptr;
  if (tangent_cost != nullptr) {
    double energy = 0;
    const bool good =
        tangent_cost->EvaluateTangent(values.data(), nullptr, &energy, nullptr, nullptr);
    return good ? energy : std::numeric_limits<double>::quiet_NaN();
  }
  residuals.resize(cost->num_residuals());
  if (!cost->Evaluate(values.data(), residuals.data(), nullptr)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  double squared = 0;
  for (const double residual : residuals) squared += residual * residual;
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
