#include "core/support/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#define BURIN_UNSEEN_BY_TSAN __attribute__((no_sanitize("thread")))
#else
#define BURIN_UNSEEN_BY_TSAN
#endif

namespace burin {
namespace {

// Tells the thread sanitizer what TBB guarantees, which it cannot see in a library that is not built with
// it: what came before a parallel call is seen by every item of it, and what the items did by what
// follows it. Each call has its own, so that calls of two runs at once have no order. Races between
// items are still found. What finds the object in an item is BURIN_UNSEEN_BY_TSAN, since an item that
// looked at its captures first would already seem to race.
class CallOrder {
 public:
#ifdef __SANITIZE_THREAD__
  void BeforeItems() { __tsan_release(&fork_); }
  void BeginItem() { __tsan_acquire(&fork_); }
  void EndItem() { __tsan_release(&join_); }
  void AfterItems() { __tsan_acquire(&join_); }

 private:
  char fork_ = 0;
  char join_ = 0;
#else
  void BeforeItems() {}
  void BeginItem() {}
  void EndItem() {}
  void AfterItems() {}
#endif
};

// What this thread's work runs in; null outside of every scope and item.
thread_local tbb::task_arena* current_arena = nullptr;

tbb::task_arena& CurrentArena() {
  static auto* all_cores = new tbb::task_arena(ThreadsFor(0));
  return current_arena != nullptr ? *current_arena : *all_cores;
}

// Tells TBB how many threads the scopes that live need together, for it creates no more than cores unless
// told (more are of use in tests), and libraries that use it on their own would take all cores.
class ProcessLimit {
 public:
  static ProcessLimit& Get() {
    static auto* limit = new ProcessLimit();
    return *limit;
  }
  // 0: no scope.
  void Replace(int old_count, int new_count) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (old_count > 0) counts_.erase(counts_.find(old_count));
    if (new_count > 0) counts_.insert(new_count);
    int sum = 0;
    for (const int count : counts_) sum += std::min(count, ThreadsFor(0));
    const int limit =
        counts_.empty() ? 0 : std::max(*counts_.rbegin(), std::min(sum, ThreadsFor(0)));
    if (limit == limit_) return;
    limit_ = limit;
    control_.reset();  // first, since of several the least holds
    if (limit > 0) control_.emplace(tbb::global_control::max_allowed_parallelism, limit);
  }

 private:
  std::mutex mutex_;
  std::multiset<int> counts_;
  int limit_ = 0;
  std::optional<tbb::global_control> control_;
};

// The innermost scope of this thread.
thread_local int scope_count = 0;

// A parallel call: its items belong to the caller's run, whichever thread takes them. One that waits
// inside an item may take an item of another call meanwhile, so each puts back what it found.
class Call {
 public:
  Call() : arena_(CurrentArena()) { order_.BeforeItems(); }
  void Finish() { order_.AfterItems(); }
  tbb::task_arena& arena() { return arena_; }

  template <typename Item>
  void Run(const Item& item) {
    order_.BeginItem();
    tbb::task_arena* const outer = current_arena;
    current_arena = &arena_;
    try {
      item();
    } catch (...) {
      current_arena = outer;
      order_.EndItem();
      throw;
    }
    current_arena = outer;
    order_.EndItem();
  }

 private:
  tbb::task_arena& arena_;
  CallOrder order_;
};

}  // namespace

int ThreadsFor(int count) {
  return count > 0 ? count : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

struct ThreadScope::Threads {
  explicit Threads(int count) : arena(count), outer_arena(current_arena), outer_count(scope_count) {
    ProcessLimit::Get().Replace(outer_count, count);
    current_arena = &arena;
    scope_count = count;
  }
  ~Threads() {
    ProcessLimit::Get().Replace(scope_count, outer_count);
    current_arena = outer_arena;
    scope_count = outer_count;
  }
  tbb::task_arena arena;
  tbb::task_arena* outer_arena;
  int outer_count;
};

ThreadScope::ThreadScope(int count) : threads_(std::make_unique<Threads>(ThreadsFor(count))) {}

ThreadScope::~ThreadScope() = default;

int ThreadCount() { return CurrentArena().max_concurrency(); }

void ParallelInvoke(const std::function<void()>& a, const std::function<void()>& b) {
  Call call;
  const auto first = [&call, &a]() BURIN_UNSEEN_BY_TSAN { call.Run(a); };
  const auto second = [&call, &b]() BURIN_UNSEEN_BY_TSAN { call.Run(b); };
  call.arena().execute([&] { tbb::parallel_invoke(first, second); });
  call.Finish();
}

void ParallelFor(int count, int grain, const std::function<void(int, int)>& body) {
  if (count <= 0) return;
  const int items = (count + grain - 1) / grain;
  Call call;
  const auto run = [&](int item) BURIN_UNSEEN_BY_TSAN {
    call.Run([&] { body(item * grain, std::min(count, (item + 1) * grain)); });
  };
  call.arena().execute([&] { tbb::parallel_for(0, items, run, tbb::simple_partitioner()); });
  call.Finish();
}

}  // namespace burin
