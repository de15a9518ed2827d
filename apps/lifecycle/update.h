// A policy's update: corrects the model in use from records, and accepts or
// refuses the correction as CorrectFromRecords() (mle/maintain) decides.

#ifndef APPS_LIFECYCLE_UPDATE_H_
#define APPS_LIFECYCLE_UPDATE_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "control/prediction_model.h"
#include "mle/data/record.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/prediction.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle::lifecycle {

// The model that a controller runs on, in the forms that are needed of it.

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

struct UpdateOptions {
  CorrectOptions correct = SimulatedRecords();
  double control_period = 1.0;
  int response_samples = 501;  // compared with the plant

  // Options for simulated records: these have no outliers, and nobody looks at
  // diagnostics or an ARX model.
  static CorrectOptions SimulatedRecords();
};

enum class Outcome {
  kNone,      // nothing was tried
  kNoChange,  // the test found no change
  kUpdated,
  kRefused,   // not validated, or because the controller cannot use it
  kReverted,  // used for some hours, then reverted: the squared error grew
};

std::string_view NameOf(Outcome outcome);
// The reverse; an error for another name.
absl::StatusOr<Outcome> ParseOutcome(std::string_view name);

struct UpdateResult {
  Outcome outcome = Outcome::kNone;
  std::string reason;  // of a refusal
  // The share of the squared one-step error that the correction removes where
  // it was held out, of the output that gains least; NaN where it was not
  // tried.
  double held_out_gain = 0.0;
  std::optional<ModelInUse> model;  // if updated
};

// ΔR, where the estimator has one, is always sought around the process model of
// `in_use`, which for the estimator arx stays that of the commissioning.
// Windows are in order of time: where they disagree, the oldest are left out.
UpdateResult UpdateModel(const ModelInUse& in_use,
                         const std::vector<Record>& windows,
                         const UpdateOptions& options);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_UPDATE_H_
