#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <thread>

namespace burin {
namespace {

int CoreCount() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

// TBB creates no more workers than cores unless told; more threads than cores are of use in tests.
struct Pool {
  explicit Pool(int count)
      : limit(tbb::global_control::max_allowed_parallelism, count), arena(count) {}
  tbb::global_control limit;
  tbb::task_arena arena;
};

std::unique_ptr<Pool>& CurrentPool() {
  static auto* pool = new std::unique_ptr<Pool>(new Pool(CoreCount()));
  return *pool;
}

}  // namespace

int SetThreadCount(int count) {
  CurrentPool().reset();
  CurrentPool() = std::make_unique<Pool>(count > 0 ? count : CoreCount());
  return ThreadCount();
}

int ThreadCount() { return CurrentPool()->arena.max_concurrency(); }

void ParallelInvoke(const std::function<void()>& a, const std::function<void()>& b) {
  CurrentPool()->arena.execute([&] { tbb::parallel_invoke(a, b); });
}

void ParallelFor(int count, int grain, const std::function<void(int, int)>& body) {
  if (count <= 0) return;
  const int items = (count + grain - 1) / grain;
  CurrentPool()->arena.execute([&] {
    tbb::parallel_for(
        0, items, [&](int item) { body(item * grain, std::min(count, (item + 1) * grain)); },
        tbb::simple_partitioner());
  });
}

}  // namespace burin
