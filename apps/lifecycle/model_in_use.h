// The model that a controller runs on, in the forms that are needed of it.

#ifndef APPS_LIFECYCLE_MODEL_IN_USE_H_
#define APPS_LIFECYCLE_MODEL_IN_USE_H_

#include "absl/status/statusor.h"
#include "control/prediction_model.h"
#include "mle/maintain/prediction.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle::lifecycle {

struct ModelInUse {
  // Gains, time constants and dead times; where `own_response`, only what the
  // next correction begins with.
  ProcessModel process;
  // Step responses are not those of `process`: the model has a ΔR.
  bool own_response = false;
  StepResponse response;  // at 0, Δt, … (only if own_response)
  Predictor predictor;    // of the model in use (only if own_response)
  control::PredictionModel prediction;
};

absl::StatusOr<ModelInUse> UseProcess(const ProcessModel& process,
                                      double control_period);

// How far a model is from the plant.
struct ModelError {
  double distance = 0.0;  // E, over the response horizon
  // The largest relative error of a gain, |K̂ − K| / |K|, and the largest error
  // of a dead time (time unit). Of responses that are not a process model's,
  // gains are those at the end of the horizon, and dead times those of
  // first-order fits; NaN where such a fit is poor.
  double gain = 0.0;
  double delay = 0.0;
};

// `samples` of step responses are compared.
absl::StatusOr<ModelError> CompareWithPlant(const ModelInUse& model,
                                            const ProcessModel& plant,
                                            double sample_time, int samples);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_MODEL_IN_USE_H_
