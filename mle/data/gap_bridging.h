// Short gaps of inputs and set points filled.

#ifndef MLE_DATA_GAP_BRIDGING_H_
#define MLE_DATA_GAP_BRIDGING_H_

#include <vector>

#include "mle/data/record.h"

namespace mle {

// Bad samples between good ones, up to `max_samples` in a row, are filled with
// the value before them; those of outputs stay bad. An input that moves at
// every so many samples only, as a controller moves it, is held up to the last
// such instant in the gap, and has the value after the gap from there on;
// eleven moves or more must show it. Returns how many samples were filled in
// each channel: outputs (none), set points, inputs (2p + m).
std::vector<int> BridgeGaps(int max_samples, Record& record);

}  // namespace mle

#endif  // MLE_DATA_GAP_BRIDGING_H_
