// Step responses of a discrete model, sampled until they have settled: what
// discrete models of every form have in common. Internal to mle/exchange.

#ifndef MLE_EXCHANGE_SAMPLED_RESPONSES_H_
#define MLE_EXCHANGE_SAMPLED_RESPONSES_H_

#include <functional>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

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

// Of a mode with a pole of this magnitude below 1.
double SamplesToDecay(double magnitude);

// The interval is Δt, or a multiple of it where that would be more than some
// 600 coefficients; of a model with ramps twice as many samples are taken, so
// that their slope is seen. InvalidArgument where the model is so slow that
// its responses would take more than 1e7 numbers, or where it has none.
absl::StatusOr<StepResponseModel> Sample(const SampledModel& model);

}  // namespace mle

#endif  // MLE_EXCHANGE_SAMPLED_RESPONSES_H_
