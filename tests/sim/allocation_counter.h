// Counts the heap allocations of the process, so that a test can assert that a
// piece of code makes none. Link mle_allocation_counter: it replaces operator
// new and, by the linker's --wrap, the C allocation functions (through which
// Eigen allocates) in everything that is linked statically.

#ifndef TESTS_SIM_ALLOCATION_COUNTER_H_
#define TESTS_SIM_ALLOCATION_COUNTER_H_

#include <cstddef>

namespace mle::testing {

// Since the start of the process.
std::size_t AllocationCount();

}  // namespace mle::testing

#endif  // TESTS_SIM_ALLOCATION_COUNTER_H_
