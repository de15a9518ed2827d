// Lengths that Fourier transforms are fast for.

#ifndef MLE_BASE_FAST_LENGTH_H_
#define MLE_BASE_FAST_LENGTH_H_

namespace mle {

// The least 2^a 3^b 5^c that is not below `count` ≥ 1; twice as many are fast
// as well.
int FastLength(int count);

}  // namespace mle

#endif  // MLE_BASE_FAST_LENGTH_H_
