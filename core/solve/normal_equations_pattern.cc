// The constructor of NormalEquations: unknowns, the pattern of H, and the place in it of every entry
// of every residual block.
#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "core/solve/normal_equations.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kGrain = 64;  // moving blocks
constexpr int kResidualGrain = 1024;

}  // namespace

NormalEquations::NormalEquations(ceres::Problem* problem, ceres::EvaluationCallback* callback,
                                 const std::vector<double*>& order)
    : callback_(callback) {
  std::vector<ceres::ResidualBlockId> ids;
  problem->GetResidualBlocks(&ids);
  MakeUnknowns(ids, order, problem);
  MakePattern();
  costs_.resize(residuals_.size());
}

void NormalEquations::MakeUnknowns(const std::vector<ceres::ResidualBlockId>& ids,
                                   const std::vector<double*>& order, ceres::Problem* problem) {
  std::unordered_map<const double*, int> index;
  const auto add_unknowns = [&](double* values) {
    const auto [entry, is_new] = index.emplace(values, -1);
    if (!is_new || problem->IsParameterBlockConstant(values)) return;
    const int tangent_size = problem->ParameterBlockTangentSize(values);
    if (tangent_size == 0) return;
    MovingBlock block;
    block.values = values;
    block.manifold = problem->GetManifold(values);
    block.size = problem->ParameterBlockSize(values);
    block.tangent_size = tangent_size;
    block.first_unknown = unknowns_;
    block.first_value = state_size_;
    for (int c = 0; c < block.size; ++c) {
      CHECK_EQ(problem->GetParameterLowerBound(values, c), -std::numeric_limits<double>::max());
      CHECK_EQ(problem->GetParameterUpperBound(values, c), std::numeric_limits<double>::max());
    }
    first_plus_.push_back(static_cast<int>(plus_jacobians_.size()));
    plus_jacobians_.resize(
        plus_jacobians_.size() + static_cast<size_t>(block.size) * block.tangent_size, 0.0);
    for (int c = 0; c < block.size && block.manifold == nullptr; ++c) {  // stays the identity
      plus_jacobians_[first_plus_.back() + c * (block.size + 1)] = 1;
    }
    unknowns_ += block.tangent_size;
    state_size_ += block.size;
    entry->second = static_cast<int>(blocks_.size());
    blocks_.push_back(block);
  };
  index.reserve(problem->NumParameterBlocks());
  for (double* values : order) {
    if (problem->HasParameterBlock(values)) add_unknowns(values);
  }
  if (static_cast<int>(index.size()) < problem->NumParameterBlocks()) {
    std::vector<double*> values;
    for (const ceres::ResidualBlockId id : ids) {
      problem->GetParameterBlocksForResidualBlock(id, &values);
      for (double* v : values) add_unknowns(v);
    }
  }

  const auto residual_count = static_cast<int>(ids.size());
  residuals_.resize(residual_count);
  int parameter_count = 0;
  for (int r = 0; r < residual_count; ++r) {
    residuals_[r].cost_function = problem->GetCostFunctionForResidualBlock(ids[r]);
    residuals_[r].tangent = dynamic_cast<const TangentCost*>(residuals_[r].cost_function);
    residuals_[r].first_parameter = parameter_count;
    parameter_count +=
        static_cast<int>(residuals_[r].cost_function->parameter_block_sizes().size());
  }
  parameters_.resize(parameter_count);
  ParallelFor(residual_count, kResidualGrain, [&](int begin, int end) {
    std::vector<double*> values;
    for (int r = begin; r < end; ++r) {
      CHECK(problem->GetLossFunctionForResidualBlock(ids[r]) == nullptr)
          << "loss functions are not supported";
      residuals_[r].unknowns = 0;
      problem->GetParameterBlocksForResidualBlock(ids[r], &values);
      int next = residuals_[r].first_parameter;
      for (double* v : values) {
        const int k = index.find(v)->second;
        parameters_[next++] = {v, k};
        if (k >= 0) residuals_[r].unknowns += blocks_[k].tangent_size;
      }
    }
  });
  int in_batch = 0;
  int largest = 0;
  for (int r = 0; r < residual_count; ++r) {
    if (r % kBatch == 0) in_batch = 0;
    residuals_[r].first_value = in_batch;
    in_batch += residuals_[r].unknowns * (residuals_[r].unknowns + 1);
    largest = std::max(largest, in_batch);
  }
  buffer_.resize(largest);
}

int NormalEquations::ParameterEnd(int residuals) const {
  return static_cast<size_t>(residuals) + 1 < residuals_.size()
             ? residuals_[residuals + 1].first_parameter
             : static_cast<int>(parameters_.size());
}

void NormalEquations::MakePattern() {
  const int block_count = static_cast<int>(blocks_.size());
  const int residual_count = static_cast<int>(residuals_.size());
  // Contributions by moving block, residual blocks in their order.
  std::vector<int> first(block_count + 1, 0);
  for (const Parameter& parameter : parameters_) {
    if (parameter.block >= 0) ++first[parameter.block + 1];
  }
  for (int k = 0; k < block_count; ++k) first[k + 1] += first[k];
  contributions_.resize(first[block_count]);
  std::vector<int> next(first.begin(), first.end() - 1);
  for (int r = 0; r < residual_count; ++r) {
    int row = 0;
    for (int p = residuals_[r].first_parameter; p < ParameterEnd(r); ++p) {
      const int k = parameters_[p].block;
      if (k < 0) continue;
      contributions_[next[k]++] = {r, row};
      row += blocks_[k].tangent_size;
    }
  }

  // Lower neighbours of every block, itself last, ascending.
  Adjacency lower;
  lower.start.assign(block_count + 1, 0);
  std::vector<std::vector<int>> chunks((block_count + kGrain - 1) / kGrain);
  ParallelFor(block_count, kGrain, [&](int begin, int end) {
    std::vector<int> found;
    std::vector<int>& chunk = chunks[begin / kGrain];
    for (int k = begin; k < end; ++k) {
      found.clear();
      for (int c = first[k]; c < first[k + 1]; ++c) {
        const int r = contributions_[c].residuals;
        for (int p = residuals_[r].first_parameter; p < ParameterEnd(r); ++p) {
          const int other = parameters_[p].block;
          if (other >= 0 && other <= k) found.push_back(other);
        }
      }
      if (found.empty()) found.push_back(k);  // in no residual block: an empty row
      std::sort(found.begin(), found.end());
      found.erase(std::unique(found.begin(), found.end()), found.end());
      chunk.insert(chunk.end(), found.begin(), found.end());
      lower.start[k + 1] = static_cast<int>(found.size());
    }
  });
  for (int k = 0; k < block_count; ++k) lower.start[k + 1] += lower.start[k];
  lower.index.resize(lower.start[block_count]);
  ParallelFor(block_count, kGrain, [&](int begin, int) {
    const std::vector<int>& chunk = chunks[begin / kGrain];
    std::copy(chunk.begin(), chunk.end(), lower.index.begin() + lower.start[begin]);
  });

  MakeRows(lower);
  MakeSlots(first, lower);
}

// Columns of every row: its lower triangle, then its upper one, block by block.
void NormalEquations::MakeRows(const Adjacency& lower) {
  const int block_count = static_cast<int>(blocks_.size());
  std::vector<int> lower_length(block_count, 0);
  std::vector<int> length(block_count, 0);
  first_mirror_.assign(block_count + 1, 0);
  for (int k = 0; k < block_count; ++k) {
    for (const int* at = lower.Begin(k); at != lower.End(k); ++at) {
      const int other = *at;
      lower_length[k] += blocks_[other].tangent_size;
      if (other == k) continue;
      length[other] += blocks_[k].tangent_size;
      ++first_mirror_[other + 1];
    }
    length[k] += lower_length[k];
  }
  for (int k = 0; k < block_count; ++k) first_mirror_[k + 1] += first_mirror_[k];
  mirrors_.resize(first_mirror_[block_count]);
  matrix_.size = unknowns_;
  matrix_.start.assign(unknowns_ + 1, 0);
  for (int k = 0; k < block_count; ++k) {
    for (int i = 0; i < blocks_[k].tangent_size; ++i) {
      const int row = blocks_[k].first_unknown + i;
      matrix_.start[row + 1] = matrix_.start[row] + length[k];
    }
  }
  matrix_.column.resize(matrix_.start[unknowns_]);
  matrix_.value.resize(matrix_.start[unknowns_]);
  matrix_.diagonal.resize(unknowns_);
  std::vector<int> filled = lower_length;
  std::vector<int> next_mirror(first_mirror_.begin(), first_mirror_.end() - 1);
  for (int k = 0; k < block_count; ++k) {
    const MovingBlock& block = blocks_[k];
    int offset = 0;
    for (const int* at = lower.Begin(k); at != lower.End(k); ++at) {
      const int other = *at;
      const MovingBlock& neighbor = blocks_[other];
      for (int i = 0; i < block.tangent_size; ++i) {
        const int row = block.first_unknown + i;
        for (int j = 0; j < neighbor.tangent_size; ++j) {
          const int column = neighbor.first_unknown + j;
          matrix_.column[matrix_.start[row] + offset + j] = column;
          if (other != k) matrix_.column[matrix_.start[column] + filled[other] + i] = row;
        }
        if (other == k) matrix_.diagonal[row] = matrix_.start[row] + offset + i;
      }
      if (other != k) {
        mirrors_[next_mirror[other]++] = {k, offset, filled[other]};
        filled[other] += block.tangent_size;
      }
      offset += neighbor.tangent_size;
    }
  }
}

// Where the entries of every contribution go, and which rows every batch touches.
void NormalEquations::MakeSlots(const std::vector<int>& first, const Adjacency& lower) {
  const int block_count = static_cast<int>(blocks_.size());
  const auto contribution_count = static_cast<int>(contributions_.size());
  const auto for_lower_parameters = [&](int k, int c, const auto& visit) {
    const int r = contributions_[c].residuals;
    for (int p = residuals_[r].first_parameter; p < ParameterEnd(r); ++p) {
      if (parameters_[p].block >= 0 && parameters_[p].block <= k) visit(parameters_[p].block);
    }
  };
  std::vector<int64_t> first_slot(contribution_count + 1, 0);
  ParallelFor(block_count, kGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      for (int c = first[k]; c < first[k + 1]; ++c) {
        for_lower_parameters(k, c, [&](int) { ++first_slot[c + 1]; });
      }
    }
  });
  for (int c = 0; c < contribution_count; ++c) first_slot[c + 1] += first_slot[c];
  slots_.resize(first_slot[contribution_count]);
  ParallelFor(block_count, kGrain, [&](int begin, int end) {
    std::vector<int> offsets;
    for (int k = begin; k < end; ++k) {
      offsets.assign(1, 0);
      for (const int* other = lower.Begin(k); other != lower.End(k); ++other) {
        offsets.push_back(offsets.back() + blocks_[*other].tangent_size);
      }
      for (int c = first[k]; c < first[k + 1]; ++c) {
        int64_t slot = first_slot[c];
        for_lower_parameters(k, c, [&](int other) {
          const int* found = std::lower_bound(lower.Begin(k), lower.End(k), other);
          slots_[slot++] = offsets[found - lower.Begin(k)];
        });
      }
    }
  });

  const int batches = (static_cast<int>(residuals_.size()) + kBatch - 1) / kBatch;
  std::vector<RowTask> tasks;  // by row
  first_task_.assign(batches + 1, 0);
  for (int k = 0; k < block_count; ++k) {
    for (int c = first[k]; c < first[k + 1];) {
      RowTask task{k, c, c, first_slot[c]};
      const int batch = contributions_[c].residuals / kBatch;
      while (task.end < first[k + 1] && contributions_[task.end].residuals / kBatch == batch) {
        ++task.end;
      }
      c = task.end;
      ++first_task_[batch + 1];
      tasks.push_back(task);
    }
  }
  for (int b = 0; b < batches; ++b) first_task_[b + 1] += first_task_[b];
  row_tasks_.resize(tasks.size());
  std::vector<int> next(first_task_.begin(), first_task_.end() - 1);
  for (const RowTask& task : tasks) {
    row_tasks_[next[contributions_[task.begin].residuals / kBatch]++] = task;
  }
}

}  // namespace burin
