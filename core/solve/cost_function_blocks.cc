#include "core/solve/cost_function_blocks.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace burin {
namespace {

// A cost function that others own.
class Borrowed : public ceres::CostFunction {
 public:
  explicit Borrowed(const ceres::CostFunction* cost) : cost_(cost) {
    set_num_residuals(cost->num_residuals());
    *mutable_parameter_block_sizes() = cost->parameter_block_sizes();
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    return cost_->Evaluate(parameters, residuals, jacobians);
  }

 private:
  const ceres::CostFunction* cost_;
};

// Of one thread.
struct Scratch {
  std::vector<const double*> values;
  std::vector<double> residuals;
  std::vector<double> ambient;  // the cost function's Jacobians
  std::vector<double> tangent;  // J, rows x unknowns
  std::vector<double*> jacobians;
};

// tangent (rows x columns at `stride`) = ambient (rows x size) * plus (size x columns).
void ApplyPlusJacobian(const double* ambient, int rows, int size, const TangentDirections& plus,
                       double* tangent, int stride) {
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < plus.columns; ++c) {
      double sum = 0;
      for (int k = 0; k < size; ++k) sum += ambient[r * size + k] * plus.plus[k * plus.columns + c];
      tangent[r * stride + c] = sum;
    }
  }
}

// The gradient, and the upper triangle of J^T J, by outer products of rows without the leading zeros of triangular
// Jacobians.
void AddRows(const std::vector<double>& tangent, const std::vector<double>& residuals, int rows,
             int columns, double weight, double* gradient, double* curvature) {
  std::fill(gradient, gradient + columns, 0.0);
  if (curvature != nullptr) {
    std::fill(curvature, curvature + static_cast<size_t>(columns) * columns, 0.0);
  }
  for (int r = 0; r < rows; ++r) {
    const double* row = tangent.data() + static_cast<size_t>(r) * columns;
    int begin = 0;
    while (begin < columns && row[begin] == 0) ++begin;
    for (int i = begin; i < columns; ++i) gradient[i] += weight * row[i] * residuals[r];
    if (curvature == nullptr) continue;
    for (int i = begin; i < columns; ++i) {
      double* target = curvature + static_cast<size_t>(i) * columns;
      for (int j = i; j < columns; ++j) target[j] += weight * row[i] * row[j];
    }
  }
}

}  // namespace

void CostFunctionBlocks::Append(std::unique_ptr<ceres::CostFunction> cost,
                                std::unique_ptr<ceres::LossFunction> loss,
                                const std::vector<int>& parameters) {
  costs_.push_back(std::move(cost));
  losses_.push_back(std::move(loss));
  parameters_.index.insert(parameters_.index.end(), parameters.begin(), parameters.end());
  parameters_.start.push_back(static_cast<int>(parameters_.index.size()));
}

bool CostFunctionBlocks::Evaluate(int k, const TangentDirections* directions, double* energy,
                                  double* gradient, double* curvature) const {
  static thread_local Scratch scratch;
  const ceres::CostFunction& cost = *costs_[k];
  const int rows = cost.num_residuals();
  const std::vector<int>& sizes = cost.parameter_block_sizes();
  const int* numbers = parameters_.Begin(k);
  scratch.values.clear();
  int columns = 0;
  size_t ambient_size = 0;
  for (size_t p = 0; p < sizes.size(); ++p) {
    scratch.values.push_back(energy_->Values(numbers[p]));
    if (gradient == nullptr || directions[p].columns == 0) continue;
    columns += directions[p].columns;
    ambient_size += static_cast<size_t>(rows) * sizes[p];
  }
  scratch.residuals.resize(rows);
  scratch.jacobians.clear();
  if (columns > 0) {
    scratch.ambient.resize(ambient_size);
    double* next = scratch.ambient.data();
    for (size_t p = 0; p < sizes.size(); ++p) {
      scratch.jacobians.push_back(directions[p].columns > 0 ? next : nullptr);
      if (directions[p].columns > 0) next += static_cast<size_t>(rows) * sizes[p];
    }
  }
  if (!cost.Evaluate(scratch.values.data(), scratch.residuals.data(),
                     columns > 0 ? scratch.jacobians.data() : nullptr)) {
    return false;
  }
  double squared = 0;
  for (const double r : scratch.residuals) squared += r * r;
  std::array<double, 3> rho = {squared, 1, 0};  // value and two derivatives
  if (losses_[k] != nullptr) losses_[k]->Evaluate(squared, rho.data());
  *energy = 0.5 * rho[0];
  if (columns == 0) return true;

  scratch.tangent.resize(static_cast<size_t>(rows) * columns);
  int column = 0;
  for (size_t p = 0; p < sizes.size(); ++p) {
    if (directions[p].columns == 0) continue;
    ApplyPlusJacobian(scratch.jacobians[p], rows, sizes[p], directions[p],
                      scratch.tangent.data() + column, columns);
    column += directions[p].columns;
  }
  AddRows(scratch.tangent, scratch.residuals, rows, columns, rho[1], gradient, curvature);
  return true;
}

CostFunctions CostFunctionBlocks::MakeCostFunctions() const {
  CostFunctions made;
  made.parameters = parameters_;
  for (const auto& cost : costs_) made.costs.push_back(std::make_unique<Borrowed>(cost.get()));
  for (const auto& loss : losses_) made.losses.push_back(loss.get());
  return made;
}

}  // namespace burin
