// The corrected model in every form that is handed over: transfer functions or
// an ARX model, first-order elements with dead time, a state-space model.
//
// First-order elements with dead time have standard errors where the records
// give them. An element that is of first order is itself. Of another shape
// g₀(Ts) of the output-error correction the best first-order fit K, T_f, L_f to
// its step response is taken; stretching the time scale T stretches that fit
// alike, so that with l₀ = (L_f − L)/T
//
//   T_f = const · T,   L_f = L + l₀ T
//
// and the errors of K, T and L carry over. An ARX model's step responses are
// fitted; its coefficients give no errors, those of the fit say how well a
// first-order element describes the response, and no more.
//
// An element that integrates is K e^{−Ls} / (s (T s + 1)), with the same ramp
// in the end and, where it is not of that shape, T and L of the smallest
// difference. K is a slope.
//
// Where the nearest first-order element is not near, the nearest one of second
// order is given too, with how near it is. It has no standard
// errors: the corrected model's own elements carry those.
//
// A discrete state-space model is a reduction (balanced_reduction.h) of the
// process model, or of the transfer functions nearest to an ARX model
// (TransferFunctionsOf()); it is then compared with the ARX model's step
// responses.

#ifndef MLE_MAINTAIN_CORRECTED_MODEL_H_
#define MLE_MAINTAIN_CORRECTED_MODEL_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/maintain/estimation.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/low_order_fit.h"

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
struct FopdtElement {
  double gain = 0.0;
  double time_constant = 0.0;
  double delay = 0.0;
  // Infinite where the records do not determine the value, 0 where it was
  // held.
  double gain_error = 0.0;
  double time_constant_error = 0.0;
  double delay_error = 0.0;
  bool integrating = false;  // the gain is a slope
  bool exact = false;  // of first order, or that with an integrator, as it is
  FopdtShape shape = FopdtShape::kFits;
  double relative_rms = 0.0;  // of the response about the fit
  // The largest difference of the step response from the fit, relative to the
  // range of the response: to its gain, where it does not overshoot.
  double largest_difference = 0.0;
  // The nearest element of second order, where the difference is above
  // kNearFopdt and that of second order at most half of it.
  std::optional<SopdtFit> second_order;
};

// As decision.least_change: what differs by less is no other response.
inline constexpr double kNearFopdt = 0.02;

// Row by row (p·m). `accepted` as for MakeCorrectedModel().
absl::StatusOr<std::vector<FopdtElement>> DescribeAsFopdt(
    const Estimate& estimate, bool accepted, const CorrectedModel& corrected);

// The elements as a process model of the initial one's channels. `time_floor`
// is the smallest time constant written: a jump has none.
ProcessModel FopdtModel(const ProcessModel& initial,
                        const std::vector<FopdtElement>& elements,
                        double time_floor);

struct StateSpaceForm {
  // With the model's names and its accuracy; absent where there is none within
  // ReductionOptions::tolerance. The error bounds of an ARX model are those to
  // `transfer_functions`.
  std::optional<NamedStateSpace> model;
  std::string reason;  // why there is none; empty where none is wanted

  // The largest value over the outputs; 0 where there is no model.
  double error_bound() const;
  double largest_difference() const;
};

// `transfer_functions` as of TransferFunctionsOf(corrected); outputs are worked
// at by `threads` (0: one for each processor).
StateSpaceForm MakeStateSpaceForm(const ProcessModel& transfer_functions,
                                  const CorrectedModel& corrected,
                                  int threads = 1);

}  // namespace mle

#endif  // MLE_MAINTAIN_CORRECTED_MODEL_H_
