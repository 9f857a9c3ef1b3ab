#include "core/solve/ceres_problem.h"

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kCostGrain = 4096;

}  // namespace

CeresProblem::CeresProblem(const RoundEnergy& energy, ceres::EvaluationCallback* callback)
    : energy_(energy) {
  ceres::Problem::Options options;
  options.evaluation_callback = callback;
  options.disable_all_safety_checks = true;
  // Counting references takes Ceres longer than the rest of what it does here.
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_ = std::make_unique<ceres::Problem>(options);
  std::vector<double*> values;
  for (const RoundEnergy::Part& part : energy.parts()) {
    CostFunctions made = part.blocks->MakeCostFunctions();
    std::vector<ceres::ResidualBlockId> ids;
    ids.reserve(made.costs.size());
    for (size_t k = 0; k < made.costs.size(); ++k) {
      values.clear();
      const auto block = static_cast<int>(k);
      for (const int* p = made.parameters.Begin(block); p != made.parameters.End(block); ++p) {
        values.push_back(energy.Values(*p));
      }
      ceres::LossFunction* loss = made.losses.empty() ? nullptr : made.losses[k];
      ids.push_back(problem_->AddResidualBlock(made.costs[k].get(), loss, values));
      costs_.push_back(std::move(made.costs[k]));
    }
    blocks_.emplace_back(part.term, std::move(ids));
  }
  for (const int p : energy.Used()) {
    // Cost functions may be cut otherwise than blocks, and have fewer parameters.
    if (!problem_->HasParameterBlock(energy.Values(p))) continue;
    if (energy.IsConstant(p)) {
      problem_->SetParameterBlockConstant(energy.Values(p));
    } else if (energy.ManifoldOf(p) != nullptr) {
      problem_->SetManifold(energy.Values(p), energy.ManifoldOf(p));
    }
  }
}

CeresProblem::~CeresProblem() {
  problem_.reset();
  ParallelFor(static_cast<int>(costs_.size()), kCostGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) costs_[k].reset();
  });
}

void CeresProblem::MoveCamerasIn(const CameraUnits& units) {
  for (int camera = 0; camera < energy_.CameraCount(); ++camera) {
    double* values = energy_.Values(energy_.FirstCamera() + camera);
    if (units.Of(camera) == nullptr || !problem_->HasParameterBlock(values)) continue;
    problem_->SetManifold(values, units.Of(camera));
  }
}

std::vector<ceres::ResidualBlockId> CeresProblem::ResidualBlocks(
    const std::function<bool(const std::string& term)>& wanted) const {
  std::vector<ceres::ResidualBlockId> found;
  for (const auto& [term, ids] : blocks_) {
    if (wanted(term)) found.insert(found.end(), ids.begin(), ids.end());
  }
  return found;
}

}  // namespace burin
