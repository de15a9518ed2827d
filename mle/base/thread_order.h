// What the thread sanitizer is told of an order that it cannot see.
//
// libtbb is not instrumented: that a task begins after it was handed over, or a
// loop returns after its bodies, holds and is not seen. What stands before
// `TellRelease(point)` is then ordered before what follows
// `TellAcquire(point)`. In other builds both do nothing.

#ifndef MLE_BASE_THREAD_ORDER_H_
#define MLE_BASE_THREAD_ORDER_H_

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace mle {

#ifdef __SANITIZE_THREAD__
inline void TellRelease(char& point) { __tsan_release(&point); }
inline void TellAcquire(char& point) { __tsan_acquire(&point); }
#else
inline void TellRelease(char& /*point*/) {}
inline void TellAcquire(char& /*point*/) {}
#endif

}  // namespace mle

#endif  // MLE_BASE_THREAD_ORDER_H_
