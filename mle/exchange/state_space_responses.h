// The step responses of a discrete state-space model, sampled until they have
// settled, so that transfer functions can describe it (description.h):
//
//   MLE_ASSIGN_OR_RETURN(const StepResponseModel steps,
//                        StepResponsesOf(named));
//   MLE_ASSIGN_OR_RETURN(const Description description, Describe(steps));

#ifndef MLE_EXCHANGE_STATE_SPACE_RESPONSES_H_
#define MLE_EXCHANGE_STATE_SPACE_RESPONSES_H_

#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/state_space_json.h"

namespace mle {

// Of a valid model, as sampled_responses.h says: every pair, until its slowest
// mode has decayed to 1e-4; pairs that integrate as ramps. InvalidArgument
// where an output follows an input at once (D ≠ 0), as no step response at the
// coefficients' times tells, or where the model is too slow.
absl::StatusOr<StepResponseModel> StepResponsesOf(const NamedStateSpace& named);

}  // namespace mle

#endif  // MLE_EXCHANGE_STATE_SPACE_RESPONSES_H_
