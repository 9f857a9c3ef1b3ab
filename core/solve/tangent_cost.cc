#include "core/solve/tangent_cost.h"

namespace burin {

ResidualsExpected::ResidualsExpected(ceres::Problem* problem) {
  std::vector<ceres::ResidualBlockId> ids;
  problem->GetResidualBlocks(&ids);
  for (const ceres::ResidualBlockId id : ids) {
    // Ceres hands the problem's cost functions out as const; they are not.
    auto* cost = const_cast<ceres::CostFunction*>(problem->GetCostFunctionForResidualBlock(id));
    if (auto* tangent_cost = dynamic_cast<TangentCost*>(cost)) costs_.push_back(tangent_cost);
  }
  for (TangentCost* cost : costs_) cost->ExpectResiduals(true);
}

ResidualsExpected::~ResidualsExpected() {
  for (TangentCost* cost : costs_) cost->ExpectResiduals(false);
}

}  // namespace burin
