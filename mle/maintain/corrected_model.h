// The corrected model in every form that is handed over.

#ifndef MLE_MAINTAIN_CORRECTED_MODEL_H_
#define MLE_MAINTAIN_CORRECTED_MODEL_H_

#include <optional>

#include "absl/status/statusor.h"
#include "mle/maintain/estimation.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

// The largest difference from the process model that an ARX model beside it may
// have (CorrectedModel::arx_error).
inline constexpr double kAcceptedArxError = 0.01;

struct CorrectedModel {
  // Missing where a ΔR of the estimator arx is accepted. Elements have the
  // initial model's shapes, or are of low order where these do not explain the
  // records.
  std::optional<ProcessModel> process;
  // In the units of the records; without coefficients where it is not made.
  // Outputs that are not ΔR's run as the process model (exact_arx.h).
  ArxModel arx;
  // Their largest difference from it in free run, static gains included,
  // relative to the response.
  double arx_error = 0.0;
  StepResponse response;  // at 0, Δt, … (response_samples)
  // Standard errors of `response`; where there is a process model.
  std::optional<StepResponse> errors;
  double max_relative_gap = 0.0;  // of all lasso fits

  // Whether the ARX model may stand beside the process model.
  bool has_arx() const {
    return arx.R.size() > 0 && arx_error <= kAcceptedArxError;
  }
};

// The initial model where `accepted` is false. Without `make_arx` a process
// model is not converted to an ARX model. InvalidArgument where it cannot be
// simulated.
absl::StatusOr<CorrectedModel> MakeCorrectedModel(const Estimate& estimate,
                                                  bool accepted,
                                                  double sample_time,
                                                  int response_samples,
                                                  bool make_arx = true);

// The process model, or elements of low order nearest to the step responses of
// the ARX model (rational_fit.h), those of `initial` where it responds alike.
absl::StatusOr<ProcessModel> TransferFunctionsOf(
    const ProcessModel& initial, const CorrectedModel& corrected);

}  // namespace mle

#endif  // MLE_MAINTAIN_CORRECTED_MODEL_H_
