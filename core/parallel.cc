#include "core/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <thread>

namespace burin {
namespace {

std::unique_ptr<tbb::task_arena>& Arena() {
  static auto* arena = new std::unique_ptr<tbb::task_arena>(
      new tbb::task_arena(static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))));
  return *arena;
}

}  // namespace

int SetThreadCount(int count) {
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Arena() = std::make_unique<tbb::task_arena>(count > 0 ? count : cores);
  return ThreadCount();
}

int ThreadCount() { return Arena()->max_concurrency(); }

void ParallelFor(int count, int grain, const std::function<void(int, int)>& body) {
  if (count <= 0) return;
  const int items = (count + grain - 1) / grain;
  Arena()->execute([&] {
    tbb::parallel_for(
        0, items, [&](int item) { body(item * grain, std::min(count, (item + 1) * grain)); },
        tbb::simple_partitioner());
  });
}

}  // namespace burin
