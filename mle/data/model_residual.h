// The residual of a process model: y − Σ_j g_ij u_j. In closed loop control
// removes a disturbance from the outputs; in the residual it remains visible.
// Internal to mle/data.

#ifndef MLE_DATA_MODEL_RESIDUAL_H_
#define MLE_DATA_MODEL_RESIDUAL_H_

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// p × (last − first + 1): samples first … last of `record`, up to a constant,
// of outputs that integrate less the line of least squares: what balances them
// is not known.
// The inputs count from `settling` samples before, as if they had been steady
// until then; a bad input keeps its last value. Responses are summed move by
// move; an element for which that would take very long is left out.
Eigen::MatrixXd ModelResidual(const Record& record, const ProcessModel& model,
                              int first, int last, int settling);

}  // namespace mle

#endif  // MLE_DATA_MODEL_RESIDUAL_H_
