// Independent pieces of work on several threads.

#ifndef MLE_BASE_PARALLEL_H_
#define MLE_BASE_PARALLEL_H_

#include <functional>

namespace mle {

// body(0), …, body(count − 1), in any order, on at most `threads` threads; 0
// takes one for each processor. A call within a body shares the threads of the
// call around it, or with 1 has the body's own alone.
// The data that body(i) writes must belong to i alone: then the result does not
// depend on the number of threads.
void ParallelFor(int count, int threads, const std::function<void(int)>& body);

}  // namespace mle

#endif  // MLE_BASE_PARALLEL_H_
