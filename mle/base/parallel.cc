#include "mle/base/parallel.h"

#include "oneapi/tbb/parallel_for.h"
#include "oneapi/tbb/partitioner.h"
#include "oneapi/tbb/task_arena.h"
#ifdef __SANITIZE_THREAD__
#include "sanitizer/tsan_interface.h"
#endif

namespace mle {
namespace {

// What the thread sanitizer is told of an order that it cannot see, for libtbb
// is not instrumented: what stands before `TellRelease(point)` comes before
// what follows `TellAcquire(point)`. In other builds both do nothing.
#ifdef __SANITIZE_THREAD__
void TellRelease(char& point) { __tsan_release(&point); }
void TellAcquire(char& point) { __tsan_acquire(&point); }
#else
void TellRelease(char& /*point*/) {}
void TellAcquire(char& /*point*/) {}
#endif

}  // namespace

void ParallelFor(int count, int threads, const std::function<void(int)>& body) {
  // Bodies begin after the call and end before its return. Among them there is
  // no order, and none is told.
  char begin = 0;
  char end = 0;
  // Reading what it captures comes before it can tell.
  const auto ordered = [&](int i) __attribute__((no_sanitize("thread"))) {
    TellAcquire(begin);
    body(i);
    TellRelease(end);
  };
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  TellRelease(begin);
  arena.execute(
      [&] { tbb::parallel_for(0, count, ordered, tbb::simple_partitioner()); });
  TellAcquire(end);
}

}  // namespace mle
