// Which parts of records are used.
//
// Windows around changes of set points, or around moves of inputs that rest
// otherwise; where no set point moves and inputs move all the time, the whole
// records. Windows without all inputs are cut or left out, then those that are
// asked to be, then the least informative. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_USED_WINDOWS_H_
#define MLE_MAINTAIN_USED_WINDOWS_H_

#include "absl/status/status.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// Sets the windows of data.records, and says what was left out. InvalidArgument
// for options, and where there is nothing to learn from.
absl::Status FindUsedWindows(const ProcessModel& model,
                             const RecordOptions& options, RecordData& data);

}  // namespace mle

#endif  // MLE_MAINTAIN_USED_WINDOWS_H_
