#include "mle/base/parallel.h"

#include "mle/base/thread_order.h"
#include "oneapi/tbb/parallel_for.h"
#include "oneapi/tbb/partitioner.h"
#include "oneapi/tbb/task_arena.h"

namespace mle {

void ParallelFor(int count, int threads, const std::function<void(int)>& body) {
  // Among bodies there is no order, and none is told.
  char begin = 0;
  char end = 0;
  const auto ordered = [&](int i) {
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
