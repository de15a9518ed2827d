// Outliers that only the model finds. Internal to mle/maintain.
//
// Neighbours do not find every outlier of a burst, the model does
// (output_reconstruction.h). It is asked about the outputs in which neighbours
// find at least one, in the output and in what the model leaves of it; with a
// robust loss, about all.

#ifndef MLE_MAINTAIN_OUTLIER_SEARCH_H_
#define MLE_MAINTAIN_OUTLIER_SEARCH_H_

#include "absl/status/status.h"
#include "mle/maintain/message.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// Marks as bad what the model finds in the windows, and says how many samples
// these are, if RecordOptions::mark asks for outliers. Outputs are independent,
// on output_error.threads. Cancelled by `progress`.
absl::Status SearchOutliers(const ProcessModel& model,
                            const RecordOptions& options,
                            const OutputErrorOptions& output_error,
                            const ProgressCallback& progress, RecordData& data);

}  // namespace mle

#endif  // MLE_MAINTAIN_OUTLIER_SEARCH_H_
