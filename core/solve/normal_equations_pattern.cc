// The constructor of NormalEquations: unknowns, the pattern of H, and the place in it of every entry
// of every block.
#include <glog/logging.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/solve/normal_equations.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kGrain = 64;  // moving blocks

// An offset in a row.
uint16_t Short(int offset) {
  CHECK_LE(offset, std::numeric_limits<uint16_t>::max()) << "a row of H has too many entries";
  return static_cast<uint16_t>(offset);
}

}  // namespace

NormalEquations::NormalEquations(const RoundEnergy& energy, ceres::EvaluationCallback* callback)
    : energy_(energy), callback_(callback) {
  MakeUnknowns();
  MakeBatches();
  MakePattern();
  if (row_blocks_ < static_cast<int>(blocks_.size())) MakeBorder();
}

void NormalEquations::MakeUnknowns() {
  moving_of_.assign(energy_.ParameterCount(), -1);
  std::vector<int> moving = energy_.Moving();
  row_blocks_ = static_cast<int>(
      std::stable_partition(moving.begin(), moving.end(),
                            [&](int parameter) { return !energy_.IsCamera(parameter); }) -
      moving.begin());
  blocks_.reserve(moving.size());
  first_plus_.reserve(moving.size());
  int plus_size = 0;
  for (const int parameter : moving) {
    first_plus_.push_back(plus_size);
    plus_size += energy_.Size(parameter) * energy_.TangentSize(parameter);
    unknowns_ += energy_.TangentSize(parameter);
  }
  plus_jacobians_.assign(plus_size, 0.0);
  block_of_unknown_.reserve(unknowns_);
  unknowns_ = 0;
  for (const int parameter : moving) {
    MovingBlock block;
    block.parameter = parameter;
    block.values = energy_.Values(parameter);
    block.manifold = energy_.ManifoldOf(parameter);
    block.size = energy_.Size(parameter);
    block.tangent_size = energy_.TangentSize(parameter);
    block.first_unknown = unknowns_;
    block.first_value = state_size_;
    for (int c = 0; c < block.size && block.manifold == nullptr; ++c) {  // stays the identity
      plus_jacobians_[first_plus_[blocks_.size()] + c * (block.size + 1)] = 1;
    }
    unknowns_ += block.tangent_size;
    state_size_ += block.size;
    moving_of_[parameter] = static_cast<int>(blocks_.size());
    block_of_unknown_.resize(unknowns_, moving_of_[parameter]);
    blocks_.push_back(block);
  }
}

void NormalEquations::MakeBatches() {
  int largest = 0;
  int first = 0;
  size_t count = 0;
  for (const RoundEnergy::Part& part : energy_.parts()) count += part.blocks->size();
  places_.reserve(count);
  for (const RoundEnergy::Part& part : energy_.parts()) {
    const Adjacency& parameters = part.blocks->parameters();
    parts_.push_back({first, static_cast<int>(batches_.size())});
    for (int begin = 0; begin < part.blocks->size(); begin += kBatch) {
      const int end = std::min(part.blocks->size(), begin + kBatch);
      batches_.push_back({part.blocks.get(), begin, end, first, false});
      first += end - begin;
      int in_batch = 0;
      for (int k = begin; k < end; ++k) {
        Place place{in_batch, 0};
        int in_rows = 0;
        for (const int* p = parameters.Begin(k); p != parameters.End(k); ++p) {
          if (moving_of_[*p] < 0) continue;
          place.unknowns += blocks_[moving_of_[*p]].tangent_size;
          in_rows += RowBlock(*p) >= 0 ? blocks_[moving_of_[*p]].tangent_size : 0;
        }
        CHECK(in_rows == 0 || in_rows == place.unknowns) << "a block with cameras and others";
        batches_.back().of_cameras |= in_rows < place.unknowns;
        in_batch += place.unknowns * (place.unknowns + 1);
        places_.push_back(place);
      }
      largest = std::max(largest, in_batch);
    }
  }
  buffer_.resize(largest);
  costs_.resize(places_.size());
}

int NormalEquations::BatchOf(int of) const {
  size_t part = parts_.size() - 1;
  while (parts_[part].first > of) --part;
  return parts_[part].first_batch + (of - parts_[part].first) / kBatch;
}

void NormalEquations::MakePattern() {
  const int block_count = row_blocks_;
  // Contributions by moving block, blocks of the energy in their order.
  std::vector<int> first(block_count + 1, 0);
  for (const RoundEnergy::Part& part : energy_.parts()) {
    for (const int parameter : part.blocks->parameters().index) {
      if (RowBlock(parameter) >= 0) ++first[RowBlock(parameter) + 1];
    }
  }
  for (int k = 0; k < block_count; ++k) first[k + 1] += first[k];
  contributions_.resize(first[block_count]);
  std::vector<int> next(first.begin(), first.end() - 1);
  for (const Batch& batch : batches_) {
    for (int of = batch.first; of < batch.first + batch.end - batch.begin; ++of) {
      int row = 0;
      for (const int* p = ParametersBegin(batch, of); p != ParametersEnd(batch, of); ++p) {
        const int k = RowBlock(*p);
        if (k < 0) continue;
        contributions_[next[k]++] = {of, row};
        row += blocks_[k].tangent_size;
      }
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
      found.assign(1, k);
      for (int c = first[k]; c < first[k + 1]; ++c) {
        const int of = contributions_[c].of;
        const Batch& batch = batches_[BatchOf(of)];
        for (const int* p = ParametersBegin(batch, of); p != ParametersEnd(batch, of); ++p) {
          const int other = RowBlock(*p);
          if (other >= 0 && other <= k) found.push_back(other);
        }
      }
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
  const int block_count = row_blocks_;
  std::vector<int> lower_length(block_count, 0);
  std::vector<int> length(block_count, 0);
  first_upper_.assign(block_count + 1, 0);
  for (int k = 0; k < block_count; ++k) {
    for (const int* at = lower.Begin(k); at != lower.End(k); ++at) {
      const int other = *at;
      lower_length[k] += blocks_[other].tangent_size;
      if (other == k) continue;
      length[other] += blocks_[k].tangent_size;
      ++first_upper_[other + 1];
    }
    length[k] += lower_length[k];
  }
  for (int k = 0; k < block_count; ++k) first_upper_[k + 1] += first_upper_[k];
  lower_of_upper_.resize(first_upper_[block_count]);
  const int rows = row_blocks_ < static_cast<int>(blocks_.size())
                       ? blocks_[row_blocks_].first_unknown
                       : unknowns_;
  matrix_.size = rows;
  matrix_.start.assign(rows + 1, 0);
  for (int k = 0; k < block_count; ++k) {
    for (int i = 0; i < blocks_[k].tangent_size; ++i) {
      const int row = blocks_[k].first_unknown + i;
      matrix_.start[row + 1] = matrix_.start[row] + length[k];
    }
  }
  matrix_.column.resize(matrix_.start[rows]);
  matrix_.value.resize(matrix_.start[rows]);
  matrix_.diagonal.resize(rows);
  std::vector<int> filled = lower_length;
  std::vector<int> next_upper(first_upper_.begin(), first_upper_.end() - 1);
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
        lower_of_upper_[next_upper[other]++] = Short(offset);
        filled[other] += block.tangent_size;
      }
      offset += neighbor.tangent_size;
    }
  }
}

// Where the entries of every contribution go, and which rows every batch touches.
void NormalEquations::MakeSlots(const std::vector<int>& first, const Adjacency& lower) {
  const int block_count = row_blocks_;
  const auto contribution_count = static_cast<int>(contributions_.size());
  const auto for_lower_parameters = [&](int k, int c, const auto& visit) {
    const int of = contributions_[c].of;
    const Batch& batch = batches_[BatchOf(of)];
    for (const int* p = ParametersBegin(batch, of); p != ParametersEnd(batch, of); ++p) {
      const int other = RowBlock(*p);
      if (other >= 0 && other <= k) visit(other);
    }
  };
  std::vector<int> first_slot(contribution_count + 1, 0);
  ParallelFor(block_count, kGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      for (int c = first[k]; c < first[k + 1]; ++c) {
        for_lower_parameters(k, c, [&](int) { ++first_slot[c + 1]; });
      }
    }
  });
  int64_t total = 0;
  for (const int slots : first_slot) total += slots;
  CHECK_LE(total, std::numeric_limits<int>::max());
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
        int slot = first_slot[c];
        for_lower_parameters(k, c, [&](int other) {
          const int* found = std::lower_bound(lower.Begin(k), lower.End(k), other);
          slots_[slot++] = Short(offsets[found - lower.Begin(k)]);
        });
      }
    }
  });

  first_task_.assign(batches_.size() + 1, 0);
  const auto for_tasks = [&](const auto& visit) {
    for (int k = 0; k < block_count; ++k) {
      for (int c = first[k]; c < first[k + 1];) {
        RowTask task{k, c, c, first_slot[c]};
        const int b = BatchOf(contributions_[c].of);
        const int batch_end = batches_[b].first + batches_[b].end - batches_[b].begin;
        while (task.end < first[k + 1] && contributions_[task.end].of < batch_end) ++task.end;
        c = task.end;
        visit(b, task);
      }
    }
  };
  for_tasks([&](int b, const RowTask&) { ++first_task_[b + 1]; });
  for (size_t b = 0; b < batches_.size(); ++b) first_task_[b + 1] += first_task_[b];
  row_tasks_.resize(first_task_.back());
  std::vector<int> next(first_task_.begin(), first_task_.end() - 1);
  for_tasks([&](int b, const RowTask& task) { row_tasks_[next[b]++] = task; });
}

}  // namespace burin
