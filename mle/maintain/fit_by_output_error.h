// The first step of EstimateModel(): the output-error correction, and what the
// test of no change makes of it.

#ifndef MLE_MAINTAIN_FIT_BY_OUTPUT_ERROR_H_
#define MLE_MAINTAIN_FIT_BY_OUTPUT_ERROR_H_

#include <vector>

#include "absl/status/status.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/message.h"
#include "mle/maintain/shared_fits.h"
#include "mle/model/process_model.h"

namespace mle {

// Sets `output_error`, `test` and `change_proposed`, and adds to `seconds` what
// was there already. Where the output-error correction is not needed, every
// element is held.
absl::Status FitByOutputError(const ProcessModel& initial,
                              const std::vector<Record>& windows,
                              const EstimationOptions& options,
                              const ProgressCallback& progress,
                              SharedFits& shared, EstimateFit& fit);

}  // namespace mle

#endif  // MLE_MAINTAIN_FIT_BY_OUTPUT_ERROR_H_
