// The quantum of rounded samples. Internal to mle/data.

#ifndef MLE_DATA_QUANTUM_H_
#define MLE_DATA_QUANTUM_H_

#include <vector>

#include "mle/data/robust_statistics.h"

namespace mle {

// The largest step of which most differences between neighbours are whole
// multiples; 0 if no such step exists, or if it is negligible: below a fiftieth
// of `noise` (or of the usual difference, if `noise` is 0).
double FindQuantum(const std::vector<SampleRow>& rows, double noise);

}  // namespace mle

#endif  // MLE_DATA_QUANTUM_H_
