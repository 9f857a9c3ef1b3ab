// One residual block of NormalEquations: its residuals, and its share of g and of H's upper triangle.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/solve/normal_equations.h"

namespace burin {
namespace {

// Scratch of one thread.
struct Scratch {
  std::vector<double> residuals;
  std::vector<double> ambient;  // the cost function's Jacobians
  std::vector<double> tangent;  // J_b, rows x m
  std::vector<double*> jacobians;
  std::vector<const double*> values;
  std::vector<TangentDirections> directions;
};

// tangent(rows x columns at stride m) = ambient (rows x size) * plus (size x columns).
void ApplyPlusJacobian(const double* ambient, int rows, int size, const double* plus, int columns,
                       double* tangent, int stride) {
  if (size == 3 && columns == 1) {
    const double n0 = plus[0];
    const double n1 = plus[1];
    const double n2 = plus[2];
    for (int r = 0; r < rows; ++r) {
      const double* row = ambient + 3 * static_cast<ptrdiff_t>(r);
      tangent[static_cast<ptrdiff_t>(r) * stride] = row[0] * n0 + row[1] * n1 + row[2] * n2;
    }
    return;
  }
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      double sum = 0;
      for (int k = 0; k < size; ++k) sum += ambient[r * size + k] * plus[k * columns + c];
      tangent[r * stride + c] = sum;
    }
  }
}

}  // namespace

bool NormalEquations::EvaluateTangent(int index, Wanted wanted) {
  static thread_local Scratch scratch;
  const Residuals& block = residuals_[index];
  const int end = ParameterEnd(index);
  scratch.values.clear();
  scratch.directions.clear();
  for (int p = block.first_parameter; p < end; ++p) {
    scratch.values.push_back(parameters_[p].values);
    const int k = parameters_[p].block;
    if (k < 0) {
      scratch.directions.push_back({nullptr, 0});
    } else {
      scratch.directions.push_back({&plus_jacobians_[first_plus_[k]], blocks_[k].tangent_size});
    }
  }
  double* gradient = wanted != Wanted::kCost ? &buffer_[block.first_value] : nullptr;
  double* curvature = wanted == Wanted::kMatrix ? gradient + block.unknowns : nullptr;
  return block.tangent->EvaluateTangent(scratch.values.data(), scratch.directions.data(),
                                        &costs_[index], gradient, curvature);
}

bool NormalEquations::EvaluateResiduals(int index, Wanted wanted) {
  if (residuals_[index].tangent != nullptr) return EvaluateTangent(index, wanted);
  static thread_local Scratch scratch;
  const Residuals& block = residuals_[index];
  const int rows = block.cost_function->num_residuals();
  const int end = ParameterEnd(index);
  const int columns = block.unknowns;
  scratch.values.clear();
  scratch.jacobians.clear();
  size_t ambient_size = 0;
  for (int p = block.first_parameter; p < end; ++p) {
    scratch.values.push_back(parameters_[p].values);
    if (parameters_[p].block >= 0) {
      ambient_size += static_cast<size_t>(rows) * blocks_[parameters_[p].block].size;
    }
  }
  if (scratch.residuals.size() < static_cast<size_t>(rows)) scratch.residuals.resize(rows);
  double* residuals = scratch.residuals.data();
  const bool derivatives = wanted != Wanted::kCost && columns > 0;
  if (derivatives) {
    if (scratch.ambient.size() < ambient_size) scratch.ambient.resize(ambient_size);
    const size_t tangent_size = static_cast<size_t>(rows) * columns;
    if (scratch.tangent.size() < tangent_size) scratch.tangent.resize(tangent_size);
    double* next = scratch.ambient.data();
    for (int p = block.first_parameter; p < end; ++p) {
      const int k = parameters_[p].block;
      scratch.jacobians.push_back(k >= 0 ? next : nullptr);
      if (k >= 0) next += static_cast<size_t>(rows) * blocks_[k].size;
    }
  }
  if (!block.cost_function->Evaluate(scratch.values.data(), residuals,
                                     derivatives ? scratch.jacobians.data() : nullptr)) {
    return false;
  }
  double squared = 0;
  for (int r = 0; r < rows; ++r) squared += residuals[r] * residuals[r];
  costs_[index] = 0.5 * squared;
  if (!derivatives) return true;

  double* tangent = scratch.tangent.data();
  int column = 0;
  for (int p = block.first_parameter; p < end; ++p) {
    const int k = parameters_[p].block;
    if (k < 0) continue;
    const MovingBlock& moving = blocks_[k];
    const double* ambient = scratch.jacobians[p - block.first_parameter];
    if (moving.manifold != nullptr) {
      ApplyPlusJacobian(ambient, rows, moving.size, &plus_jacobians_[first_plus_[k]],
                        moving.tangent_size, tangent + column, columns);
    } else {
      for (int r = 0; r < rows; ++r) {
        std::copy(ambient + r * moving.size, ambient + (r + 1) * moving.size,
                  tangent + r * columns + column);
      }
    }
    column += moving.tangent_size;
  }

  // The upper triangle of J^T J by outer products of rows, without the leading zeros of triangular
  // Jacobians.
  double* gradient = &buffer_[block.first_value];
  double* matrix = gradient + columns;
  std::fill(gradient, gradient + columns, 0.0);
  if (wanted == Wanted::kMatrix) {
    std::fill(matrix, matrix + static_cast<size_t>(columns) * columns, 0.0);
  }
  for (int r = 0; r < rows; ++r) {
    const double* row = tangent + static_cast<size_t>(r) * columns;
    int begin = 0;
    while (begin < columns && row[begin] == 0) ++begin;
    for (int i = begin; i < columns; ++i) gradient[i] += row[i] * residuals[r];
    if (wanted != Wanted::kMatrix) continue;
    for (int i = begin; i < columns; ++i) {
      double* target = matrix + static_cast<size_t>(i) * columns;
      for (int j = i; j < columns; ++j) target[j] += row[i] * row[j];
    }
  }
  return true;
}

}  // namespace burin
