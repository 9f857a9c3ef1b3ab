// The one place where burin starts threads. Work is cut into items by the caller, never by the
// number of threads, and each item writes only what it owns: results are the same bytes for any
// thread count.
#pragma once

#include <functional>
#include <memory>

namespace burin {

// `count`, or the number of the machine's cores where it is 0.
int ThreadsFor(int count);

// The threads of a run: while the object lives, ParallelFor uses that many (0 = all cores) in the thread
// that made it, and in the items of what runs in it. Runs in other threads have their own, at the same
// time. Without one ParallelFor uses all cores. Scopes of one thread end in the reverse order of their
// beginning.
class ThreadScope {
 public:
  explicit ThreadScope(int count);
  ~ThreadScope();
  ThreadScope(const ThreadScope&) = delete;
  ThreadScope& operator=(const ThreadScope&) = delete;

 private:
  struct Threads;
  std::unique_ptr<Threads> threads_;
};

// Threads that ParallelFor uses here.
int ThreadCount();

// Calls body(begin, end) for consecutive ranges covering [0, count), each `grain` long (the last
// may be shorter), in any order and on several threads. Exceptions from body are rethrown.
void ParallelFor(int count, int grain, const std::function<void(int begin, int end)>& body);

// Calls both, at the same time where there is a thread to spare; they may use ParallelFor.
void ParallelInvoke(const std::function<void()>& a, const std::function<void()>& b);

}  // namespace burin
