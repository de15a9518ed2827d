#include "mle/base/parallel.h"

#include <utility>

#include "oneapi/tbb/parallel_for.h"
#include "oneapi/tbb/partitioner.h"
#include "oneapi/tbb/task_arena.h"
#ifdef __SANITIZE_THREAD__
#include "sanitizer/tsan_interface.h"
#endif

namespace mle {
namespace {

// Tells the thread sanitizer of an order that it cannot see, as libtbb is not
// instrumented: everything before `TellRelease(point)` happens before
// everything after `TellAcquire(point)`. In other builds both do nothing.
#ifdef __SANITIZE_THREAD__
void TellRelease(char& point) { __tsan_release(&point); }
void TellAcquire(char& point) { __tsan_acquire(&point); }
#else
void TellRelease(char& /*point*/) {}
void TellAcquire(char& /*point*/) {}
#endif

// Whether this thread is within a body.
thread_local bool within = false;

}  // namespace

void ParallelFor(int count, int threads, const std::function<void(int)>& body) {
  // Bodies begin after the call and end before its return. Among them there is
  // no order, and none is told.
  char begin = 0;
  char end = 0;
  // Reading what it captures comes before it can tell.
  const auto ordered = [&](int i) __attribute__((no_sanitize("thread"))) {
    TellAcquire(begin);
    const bool was_within = std::exchange(within, true);
    body(i);
    within = was_within;
    TellRelease(end);
  };
  const auto run = [&] {
    tbb::parallel_for(0, count, ordered, tbb::simple_partitioner());
  };
  TellRelease(begin);
  if (within && threads == 1) {
    for (int i = 0; i < count; ++i) ordered(i);
  } else if (within) {
    // Who waits for these pieces takes no others meanwhile, which would lie
    // upon them on its stack.
    tbb::this_task_arena::isolate(run);
  } else {
    tbb::task_arena(threads > 0 ? threads : tbb::task_arena::automatic)
        .execute(run);
  }
  TellAcquire(end);
}

}  // namespace mle
