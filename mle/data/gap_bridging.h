// Short gaps of a record filled.

#ifndef MLE_DATA_GAP_BRIDGING_H_
#define MLE_DATA_GAP_BRIDGING_H_

#include <vector>

#include "mle/data/record.h"

namespace mle {

// Bad samples between good ones, up to `max_samples` in a row, are filled:
// inputs and set points held, outputs (if asked for) linear. An input that
// moves at every so many samples only, as a controller moves it, is held up to
// the last such instant in the gap, and has the value after the gap from there
// on; eleven moves or more must show it. Returns how many samples were filled
// in each channel: outputs, set points, inputs (2p + m).
std::vector<int> BridgeGaps(int max_samples, bool bridge_outputs,
                            Record& record);

}  // namespace mle

#endif  // MLE_DATA_GAP_BRIDGING_H_
