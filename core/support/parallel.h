// The one place where burin starts threads. Work is cut into items by the caller, never by the
// number of threads, and each item writes only what it owns: results are the same bytes for any
// thread count.
#pragma once

#include <functional>

namespace burin {

// Threads used by ParallelFor from now on; 0 = all cores of the machine. Returns the number in use.
int SetThreadCount(int count);
int ThreadCount();

// Calls body(begin, end) for consecutive ranges covering [0, count), each `grain` long (the last
// may be shorter), in any order and on several threads. Exceptions from body are rethrown.
void ParallelFor(int count, int grain, const std::function<void(int begin, int end)>& body);

// Calls both, at the same time where there is a thread to spare; they may use ParallelFor.
void ParallelInvoke(const std::function<void()>& a, const std::function<void()>& b);

}  // namespace burin
