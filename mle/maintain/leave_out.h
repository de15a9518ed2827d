// Windows that are not to be used. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_LEAVE_OUT_H_
#define MLE_MAINTAIN_LEAVE_OUT_H_

#include <vector>

#include "absl/status/status.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// Removes the windows that contain one of the times, each with a note. An error
// names leave_out: for a time in no window, and if no window is left.
absl::Status LeaveOutWindows(const ProcessModel& model,
                             const std::vector<double>& times,
                             RecordData& data);

}  // namespace mle

#endif  // MLE_MAINTAIN_LEAVE_OUT_H_
