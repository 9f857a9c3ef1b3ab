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
  if (wanted != Wanted::kCost) {
    gradient->setZero(unknowns_);
    ParallelFor(static_cast<int>(blocks_.size()), kBlockGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        const ceres::Manifold* manifold = blocks_[k].manifold;
        if (manifold != nullptr &&
            !manifold->PlusJacobian(blocks_[k].values, &plus_jacobians_[first_plus_[k]])) {
          good = false;
        }
      }
    });
  }
  for (const RoundEnergy::Part& part : energy_.parts()) {
    part.blocks->Prepare(wanted == Wanted::kMatrix);
  }
  if (wanted == Wanted::kMatrix) {
    std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
    border_.curvature().setZero();
  }
  for (size_t b = 0; b < batches_.size() && good; ++b) {
    const Batch& batch = batches_[b];
    ParallelFor(batch.end - batch.begin, kGrain, [&](int begin, int end) {
      for (int k = batch.begin + begin; k < batch.begin + end; ++k) {
        if (!EvaluateBlock(batch, k, wanted)) good = false;
      }
    });
    if (wanted == Wanted::kCost) continue;
    if (batch.of_cameras && good) AddToBorder(batch, wanted, gradient);
    ParallelFor(first_task_[b + 1] - first_task_[b], kGrain, [&](int begin, int end) {
      for (int t = begin; t < end; ++t) {
        AddRows(batch, row_tasks_[first_task_[b] + t], wanted, gradient);
      }
    });
  }
  if (!good) return false;
  if (wanted == Wanted::kMatrix) {
    CopyLowerToUpper();
    if (!border_.empty()) FinishBorder();
  }
  *cost = ChunkedSum(static_cast<int>(costs_.size()), [&](int begin, int end) {
    double sum = 0;
    for (int k = begin; k < end; ++k) sum += costs_[k];
    return sum;
  });
  return std::isfinite(*cost);
}

bool NormalEquations::EvaluateBlock(const Batch& batch, int k, Wanted wanted) {
  static thread_local std::vector<TangentDirections> directions;
  const int of = batch.first + k - batch.begin;
  directions.clear();
  for (const int* p = ParametersBegin(batch, of); p != ParametersEnd(batch, of); ++p) {
    const int moving = moving_of_[*p];
    if (moving < 0) {
      directions.push_back({nullptr, 0});
    } else {
      directions.push_back({&plus_jacobians_[first_plus_[moving]], blocks_[moving].tangent_size});
    }
  }
  double* gradient = wanted != Wanted::kCost ? &buffer_[places_[of].first_value] : nullptr;
  double* curvature = wanted == Wanted::kMatrix ? gradient + places_[of].unknowns : nullptr;
  return batch.blocks->Evaluate(k, directions.data(), &costs_[of], gradient, curvature);
}

void NormalEquations::AddRows(const Batch& batch, const RowTask& task, Wanted wanted,
                              Eigen::VectorXd* gradient) {
  const MovingBlock& moving = blocks_[task.block];
  const int height = moving.tangent_size;
  double* gradient_rows = gradient->data() + moving.first_unknown;
  const int64_t* row_start = &matrix_.start[moving.first_unknown];
  double* values = matrix_.value.data();
  const uint16_t* slot = slots_.data() + task.first_slot;
  for (int c = task.begin; c < task.end; ++c) {
    const auto& [of, row] = contributions_[c];
    const Place& place = places_[of];
    const double* local_gradient = &buffer_[place.first_value];
    const double* local = local_gradient + place.unknowns;
    for (int i = 0; i < height; ++i) gradient_rows[i] += local_gradient[row + i];
    if (wanted != Wanted::kMatrix) continue;
    const ptrdiff_t stride = place.unknowns;
    int column = 0;
    for (const int* p = ParametersBegin(batch, of); p != ParametersEnd(batch, of); ++p) {
      const int other = RowBlock(*p);
      if (other < 0) continue;
      const int width = blocks_[other].tangent_size;
      if (other <= task.block) {
        const int offset = *slot++;
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
  ParallelFor(row_blocks_, kBlockGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const MovingBlock& block = blocks_[k];
      const int64_t first = matrix_.start[block.first_unknown];
      // Behind the diagonal's block.
      int64_t upper = matrix_.diagonal[block.first_unknown] - first + block.tangent_size;
      for (int u = first_upper_[k]; u < first_upper_[k + 1]; ++u) {
        const int column = matrix_.column[first + upper];
        const int width = blocks_[block_of_unknown_[column]].tangent_size;
        for (int i = 0; i < block.tangent_size; ++i) {
          double* target = &matrix_.value[matrix_.start[block.first_unknown + i] + upper];
          for (int j = 0; j < width; ++j) {
            target[j] = matrix_.value[matrix_.start[column + j] + lower_of_upper_[u] + i];
          }
        }
        upper += width;
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
