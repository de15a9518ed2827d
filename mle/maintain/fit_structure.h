// The first step of EstimateModel(): the structured correction, and what the
// test of no change makes of it.

#ifndef MLE_MAINTAIN_FIT_STRUCTURE_H_
#define MLE_MAINTAIN_FIT_STRUCTURE_H_

#include <vector>

#include "absl/status/status.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/progress.h"
#include "mle/maintain/shared_fits.h"
#include "mle/model/process_model.h"

namespace mle {

// Sets `structured`, `test` and `change_proposed`, and adds to `seconds` what
// was there already. Where the structured correction is not needed, every
// element is held.
absl::Status FitStructure(const ProcessModel& initial,
                          const std::vector<Record>& windows,
                          const EstimationOptions& options,
                          const ProgressCallback& progress, SharedFits& shared,
                          EstimateFit& fit);

}  // namespace mle

#endif  // MLE_MAINTAIN_FIT_STRUCTURE_H_
