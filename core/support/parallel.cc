#include "core/support/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <thread>

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

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

// Tells the thread sanitizer what TBB guarantees, which it cannot see in a library that is not built with
// it: what came before a parallel call is seen by every item, and what the items did by what follows it.
// Races between items are still found. Of nothing else than these two addresses, since an item that
// looked at its captures first would already seem to race.
#ifdef __SANITIZE_THREAD__
char fork_order = 0;
char join_order = 0;
void BeforeItems() { __tsan_release(&fork_order); }
void BeginItem() { __tsan_acquire(&fork_order); }
void EndItem() { __tsan_release(&join_order); }
void AfterItems() { __tsan_acquire(&join_order); }
#else
void BeforeItems() {}
void BeginItem() {}
void EndItem() {}
void AfterItems() {}
#endif

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
  const auto first = [&] {
    BeginItem();
    a();
    EndItem();
  };
  const auto second = [&] {
    BeginItem();
    b();
    EndItem();
  };
  BeforeItems();
  CurrentPool()->arena.execute([&] { tbb::parallel_invoke(first, second); });
  AfterItems();
}

void ParallelFor(int count, int grain, const std::function<void(int, int)>& body) {
  if (count <= 0) return;
  const int items = (count + grain - 1) / grain;
  const auto run = [&](int item) {
    BeginItem();
    body(item * grain, std::min(count, (item + 1) * grain));
    EndItem();
  };
  BeforeItems();
  CurrentPool()->arena.execute(
      [&] { tbb::parallel_for(0, items, run, tbb::simple_partitioner()); });
  AfterItems();
}

}  // namespace burin
