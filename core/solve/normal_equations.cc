#include "core/solve/normal_equations.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kGrain = 64;
constexpr int kBlockGrain = 2048;  // moving blocks

}  // namespace

bool NormalEquations::EvaluateCost(double* cost) { return Run(Wanted::kCost, cost, nullptr); }

bool NormalEquations::EvaluateGradient(double* cost, Eigen::VectorXd* gradient) {
  return Run(Wanted::kGradient, cost, gradient);
}

bool NormalEquations::Evaluate(double* cost, Eigen::VectorXd* gradient) {
  return Run(Wanted::kMatrix, cost, gradient);
}

bool NormalEquations::Run(Wanted wanted, double* cost, Eigen::VectorXd* gradient) {
  if (callback_ != nullptr) {
    callback_->PrepareForEvaluation(wanted != Wanted::kCost, point_is_new_);
  }
  point_is_new_ = false;
  std::atomic<bool> good{true};
  const int block_count = static_cast<int>(blocks_.size());
  const int residual_count = static_cast<int>(residuals_.size());
  if (wanted != Wanted::kCost) {
    gradient->setZero(unknowns_);
    ParallelFor(block_count, kBlockGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        const ceres::Manifold* manifold = blocks_[k].manifold;
        if (manifold != nullptr &&
            !manifold->PlusJacobian(blocks_[k].values, &plus_jacobians_[first_plus_[k]])) {
          good = false;
        }
      }
    });
  }
  if (wanted == Wanted::kMatrix) std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
  for (int first = 0; first < residual_count && good; first += kBatch) {
    const int count = std::min(kBatch, residual_count - first);
    ParallelFor(count, kGrain, [&](int begin, int end) {
      for (int r = begin; r < end; ++r) {
        if (!EvaluateResiduals(first + r, wanted)) good = false;
      }
    });
    if (wanted == Wanted::kCost) continue;
    const int batch = first / kBatch;
    ParallelFor(first_task_[batch + 1] - first_task_[batch], kGrain, [&](int begin, int end) {
      for (int t = begin; t < end; ++t) {
        AddRows(row_tasks_[first_task_[batch] + t], wanted, gradient);
      }
    });
  }
  if (!good) return false;
  if (wanted == Wanted::kMatrix) CopyLowerToUpper();
  *cost = ChunkedSum(residual_count, [&](int begin, int end) {
    double sum = 0;
    for (int r = begin; r < end; ++r) sum += costs_[r];
    return sum;
  });
  return std::isfinite(*cost);
}

void NormalEquations::AddRows(const RowTask& task, Wanted wanted, Eigen::VectorXd* gradient) {
  const MovingBlock& moving = blocks_[task.block];
  const int height = moving.tangent_size;
  double* gradient_rows = gradient->data() + moving.first_unknown;
  const int64_t* row_start = &matrix_.start[moving.first_unknown];
  double* values = matrix_.value.data();
  int64_t slot = task.first_slot;
  for (int c = task.begin; c < task.end; ++c) {
    const Residuals& block = residuals_[contributions_[c].residuals];
    const Parameter* parameters = &parameters_[block.first_parameter];
    const int count = ParameterEnd(contributions_[c].residuals) - block.first_parameter;
    const int row = contributions_[c].row;
    const double* local_gradient = &buffer_[block.first_value];
    const double* local = local_gradient + block.unknowns;
    for (int i = 0; i < height; ++i) gradient_rows[i] += local_gradient[row + i];
    if (wanted != Wanted::kMatrix) continue;
    const ptrdiff_t stride = block.unknowns;
    int column = 0;
    for (int p = 0; p < count; ++p) {
      const int other = parameters[p].block;
      if (other < 0) continue;
      const int width = blocks_[other].tangent_size;
      if (other <= task.block) {
        const int offset = slots_[slot++];
        for (int i = 0; i < height; ++i) {
          double* target = values + row_start[i] + offset;
          for (int j = 0; j < width; ++j) {
            // `local` is an upper triangle.
            const int low = std::min(row + i, column + j);
            const int high = std::max(row + i, column + j);
            target[j] += local[low * stride + high];
          }
        }
      }
      column += width;
    }
  }
}

void NormalEquations::CopyLowerToUpper() {
  ParallelFor(static_cast<int>(blocks_.size()), kBlockGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const MovingBlock& block = blocks_[k];
      for (int m = first_mirror_[k]; m < first_mirror_[k + 1]; ++m) {
        const Mirror& mirror = mirrors_[m];
        const MovingBlock& other = blocks_[mirror.block];
        for (int i = 0; i < block.tangent_size; ++i) {
          double* target = &matrix_.value[matrix_.start[block.first_unknown + i] + mirror.upper];
          for (int j = 0; j < other.tangent_size; ++j) {
            target[j] = matrix_.value[matrix_.start[other.first_unknown + j] + mirror.lower + i];
          }
        }
      }
    }
  });
}

void NormalEquations::Save(State* state) const {
  state->resize(state_size_);
  for (const MovingBlock& block : blocks_) {
    std::copy(block.values, block.values + block.size, state->begin() + block.first_value);
  }
}

void NormalEquations::Restore(const State& state) {
  for (const MovingBlock& block : blocks_) {
    std::copy(&state[block.first_value], &state[block.first_value] + block.size, block.values);
  }
  point_is_new_ = true;
}

bool NormalEquations::SetPlus(const State& state, const Eigen::VectorXd& delta) {
  point_is_new_ = true;
  std::atomic<bool> good{true};
  ParallelFor(static_cast<int>(blocks_.size()), kBlockGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const MovingBlock& block = blocks_[k];
      const double* from = &state[block.first_value];
      const double* step = &delta[block.first_unknown];
      if (block.manifold != nullptr) {
        if (!block.manifold->Plus(from, step, block.values)) good = false;
      } else {
        for (int c = 0; c < block.size; ++c) block.values[c] = from[c] + step[c];
      }
    }
  });
  return good;
}

}  // namespace burin
