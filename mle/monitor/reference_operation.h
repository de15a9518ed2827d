// How a plant runs in the reference period of a watch. Internal to mle/monitor.

#ifndef MLE_MONITOR_REFERENCE_OPERATION_H_
#define MLE_MONITOR_REFERENCE_OPERATION_H_

#include <vector>

#include "mle/data/record.h"
#include "mle/monitor/model_watch.h"

namespace mle {

// Usable samples of an output that a reference needs.
inline constexpr int kLeastReference = 200;

// p, or none where records have no set points. `rest`: the same records,
// outputs around changes left out.
std::vector<OutputOperation> OperationOf(const std::vector<WatchBatch>& batches,
                                         const std::vector<Record>& rest);

}  // namespace mle

#endif  // MLE_MONITOR_REFERENCE_OPERATION_H_
