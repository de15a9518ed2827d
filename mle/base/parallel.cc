#include "mle/base/parallel.h"

#include "oneapi/tbb/parallel_for.h"
#include "oneapi/tbb/partitioner.h"
#include "oneapi/tbb/task_arena.h"

namespace mle {

void ParallelFor(int count, int threads, const std::function<void(int)>& body) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute(
      [&] { tbb::parallel_for(0, count, body, tbb::simple_partitioner()); });
}

}  // namespace mle
