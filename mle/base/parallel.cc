#include "mle/base/parallel.h"

#include "oneapi/tbb/parallel_for.h"
#include "oneapi/tbb/partitioner.h"
#include "oneapi/tbb/task_arena.h"

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace mle {
namespace {

// libtbb is not instrumented: the thread sanitizer does not see that a body
// begins after its call and ends before its return, and is told. Of the order
// among bodies, which have none, it is told nothing.
#ifdef __SANITIZE_THREAD__
void Release(char& point) { __tsan_release(&point); }
void Acquire(char& point) { __tsan_acquire(&point); }
#else
void Release(char&) {}
void Acquire(char&) {}
#endif

}  // namespace

void ParallelFor(int count, int threads, const std::function<void(int)>& body) {
  char begin = 0;
  char end = 0;
  const auto ordered = [&](int i) {
    Acquire(begin);
    body(i);
    Release(end);
  };
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  Release(begin);
  arena.execute(
      [&] { tbb::parallel_for(0, count, ordered, tbb::simple_partitioner()); });
  Acquire(end);
}

}  // namespace mle
