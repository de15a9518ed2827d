// The step responses of a discrete state-space model, sampled until they have
// settled, so that transfer functions can describe it (description.h):
//
//   MLE_ASSIGN_OR_RETURN(const StepResponseModel steps,
//                        StepResponsesOf(named));
//   MLE_ASSIGN_OR_RETURN(const Description description, Describe(steps));

#ifndef MLE_EXCHANGE_STATE_SPACE_RESPONSES_H_
#define MLE_EXCHANGE_STATE_SPACE_RESPONSES_H_

#include <functional>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space_json.h"
#include "mle/model/step_response.h"

namespace mle {

// Step responses of a valid model, by Sample(): every pair, until its slowest
// mode has decayed to 1e-4; pairs that integrate as ramps. InvalidArgument
// where an output follows an input at once (D ≠ 0), which no step response at
// the coefficients' times tells, or where the model is too slow.
absl::StatusOr<StepResponseModel> StepResponsesOf(const NamedStateSpace& named);

// Step responses of a discrete model, sampled until they have settled: what
// discrete models of every form have in common.
struct SampledModel {
  ProcessModel channels;     // all elements zero
  double sample_time = 0.0;  // Δt
  // Samples in which every dead time has passed and every mode but those that
  // integrate has decayed to kSettled: SamplesToDecay() and the dead times.
  double samples = 0.0;
  Eigen::MatrixXi ramps;     // p × m: 1 where a pair ends in a ramp
  Eigen::MatrixXd rounding;  // p × m: a response no larger than this is zero
  std::function<StepResponse(int samples)> respond;
};

// Number of samples after which a mode with a pole of this magnitude, below 1,
// has decayed to 1e-4.
double SamplesToDecay(double magnitude);

// The interval is Δt, or a multiple of it where that would be more than some
// 600 coefficients; of a model with ramps twice as many samples are taken, so
// that their slope is seen. InvalidArgument where the model is so slow that
// its responses would take more than 1e7 numbers, or where it has none.
absl::StatusOr<StepResponseModel> Sample(const SampledModel& model);

}  // namespace mle

#endif  // MLE_EXCHANGE_STATE_SPACE_RESPONSES_H_
