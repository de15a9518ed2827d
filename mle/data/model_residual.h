// What a process model leaves of the outputs: y − Σ_j g_ij u_j. In closed loop
// a disturbance shows in it as it came, while in the outputs the control has
// taken it away. Internal to mle/data.

#ifndef MLE_DATA_MODEL_RESIDUAL_H_
#define MLE_DATA_MODEL_RESIDUAL_H_

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// p × (last − first + 1): samples first … last of `record`, up to a constant.
// The inputs count from `settling` samples before, as if they had been steady
// until then; a bad one is taken to be as before. Responses are summed up move
// by move; an element for which that would take very long is left out.
Eigen::MatrixXd ModelResidual(const Record& record, const ProcessModel& model,
                              int first, int last, int settling);

}  // namespace mle

#endif  // MLE_DATA_MODEL_RESIDUAL_H_
