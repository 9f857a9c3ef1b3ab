#include "core/solve/round_energy.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>

#include "core/solve/cost_function_blocks.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kBlockGrain = 1024;

}  // namespace

RoundEnergy::RoundEnergy(RoundParameters* parameters)
    : parameters_(parameters),
      constant_(parameters->vertices.size() + parameters->cameras.size(), 0),
      manifolds_(constant_.size(), nullptr) {}

RoundEnergy::~RoundEnergy() = default;

void RoundEnergy::BeginTerm(const std::string& name) {
  term_ = name;
  open_ = nullptr;
}

void RoundEnergy::Add(std::unique_ptr<EnergyBlocks> blocks) {
  parts_.push_back({term_, std::move(blocks)});
  open_ = nullptr;
}

void RoundEnergy::Add(std::unique_ptr<ceres::CostFunction> cost,
                      std::unique_ptr<ceres::LossFunction> loss,
                      const std::vector<double*>& parameters) {
  if (open_ == nullptr) {
    auto blocks = std::make_unique<CostFunctionBlocks>(this);
    CostFunctionBlocks* open = blocks.get();
    Add(std::move(blocks));
    open_ = open;
  }
  const std::vector<int>& sizes = cost->parameter_block_sizes();
  CHECK_EQ(sizes.size(), parameters.size());
  std::vector<int> numbers;
  for (size_t p = 0; p < parameters.size(); ++p) {
    numbers.push_back(NumberOf(parameters[p], sizes[p]));
  }
  open_->Append(std::move(cost), std::move(loss), numbers);
}

int RoundEnergy::NumberOf(double* values, int size) {
  std::vector<Eigen::Vector3d>& vertices = parameters_->vertices;
  if (!vertices.empty() && values >= vertices.front().data() && values <= vertices.back().data()) {
    const ptrdiff_t offset = values - vertices.front().data();
    CHECK_EQ(offset % 3, 0) << "not the first coordinate of a vertex";
    CHECK_EQ(size, 3);
    return static_cast<int>(offset / 3);
  }
  std::vector<CameraPose>& cameras = parameters_->cameras;
  if (!cameras.empty() && values >= cameras.front().data() && values <= cameras.back().data()) {
    const ptrdiff_t offset = values - cameras.front().data();
    CHECK_EQ(offset % CameraPose::kSize, 0) << "not the first number of a camera";
    CHECK_EQ(size, CameraPose::kSize);
    return FirstCamera() + static_cast<int>(offset / CameraPose::kSize);
  }
  const auto [entry, is_new] = extra_numbers_.emplace(values, ParameterCount());
  if (is_new) {
    extras_.push_back({values, size});
    constant_.push_back(0);
    manifolds_.push_back(nullptr);
  }
  CHECK_EQ(size, Size(entry->second));
  return entry->second;
}

int RoundEnergy::ParameterCount() const { return static_cast<int>(constant_.size()); }

double* RoundEnergy::Values(int parameter) const {
  if (parameter < FirstCamera()) return parameters_->vertices[parameter].data();
  if (IsCamera(parameter)) return parameters_->cameras[parameter - FirstCamera()].data();
  return extras_[parameter - FirstExtra()].values;
}

int RoundEnergy::Size(int parameter) const {
  if (parameter < FirstCamera()) return 3;
  return IsCamera(parameter) ? CameraPose::kSize : extras_[parameter - FirstExtra()].size;
}

int RoundEnergy::TangentSize(int parameter) const {
  const ceres::Manifold* manifold = manifolds_[parameter];
  return manifold != nullptr ? manifold->TangentSize() : Size(parameter);
}

void RoundEnergy::SetConstant(int parameter) { constant_[parameter] = 1; }

void RoundEnergy::SetManifold(int parameter, ceres::Manifold* manifold) {
  CHECK(manifold == nullptr || manifold->AmbientSize() == Size(parameter));
  manifolds_[parameter] = manifold;
}

std::vector<int> RoundEnergy::Used() const {
  std::vector<char> is_used(ParameterCount(), 0);
  for (const Part& part : parts_) {
    for (const int parameter : part.blocks->parameters().index) is_used[parameter] = 1;
  }
  std::vector<int> used;
  for (int p = 0; p < ParameterCount(); ++p) {
    if (is_used[p] != 0) used.push_back(p);
  }
  return used;
}

std::vector<int> RoundEnergy::Moving() const {
  std::vector<int> moving = Used();
  moving.erase(std::remove_if(moving.begin(), moving.end(),
                              [&](int p) { return IsConstant(p) || TangentSize(p) == 0; }),
               moving.end());
  return moving;
}

double RoundEnergy::EnergyOf(const std::string& term) const {
  double sum = 0;
  std::vector<double> energies;
  for (const Part& part : parts_) {
    if (part.term != term) continue;
    part.blocks->Prepare(/*curvature=*/false);
    energies.assign(part.blocks->size(), 0);
    ParallelFor(part.blocks->size(), kBlockGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        if (!part.blocks->Evaluate(k, nullptr, &energies[k], nullptr, nullptr)) {
          energies[k] = std::numeric_limits<double>::quiet_NaN();
        }
      }
    });
    for (const double energy : energies) sum += energy;
  }
  return sum;
}

}  // namespace burin
