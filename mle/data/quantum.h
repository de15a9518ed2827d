// The step that samples are multiples of. Internal to mle/data.

#ifndef MLE_DATA_QUANTUM_H_
#define MLE_DATA_QUANTUM_H_

#include <vector>

#include "mle/data/robust_statistics.h"

namespace mle {

// The largest step of which most differences between neighbours are whole
// multiples; 0 if there is none, or if it is below a fiftieth of `noise` (or of
// the usual difference, if that is 0), so that it does not matter.
double FindQuantum(const std::vector<SampleRow>& rows, double noise);

}  // namespace mle

#endif  // MLE_DATA_QUANTUM_H_
