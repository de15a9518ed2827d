// What a model leaves of records in usual operation: measured less simulated
// outputs. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_USUAL_RESIDUALS_H_
#define MLE_MAINTAIN_USUAL_RESIDUALS_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/prediction.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// p × N of each run of known inputs in the records. NaN where an output is not
// measured, as long as the inputs before the run may act, and outside of the
// windows and of `rest`, the other parts in usual operation.
absl::StatusOr<std::vector<Eigen::MatrixXd>> UsualResiduals(
    const ProcessModel& model, const RecordData& data,
    const std::vector<Record>& rest);

}  // namespace mle

#endif  // MLE_MAINTAIN_USUAL_RESIDUALS_H_
