// The corrected model as first-order elements with dead time, with standard
// errors where the records give them.
//
// An element that is of first order is itself. Of another shape g₀(Ts) of the
// output-error correction the best first-order fit K, T_f, L_f to its step
// response is taken; stretching the time scale T stretches that fit alike, so
// that with l₀ = (L_f − L)/T
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
// order is given too (sopdt_fit.h), with how near it is. It has no standard
// errors: the corrected model's own elements carry those.

#ifndef MLE_MAINTAIN_FOPDT_DESCRIPTION_H_
#define MLE_MAINTAIN_FOPDT_DESCRIPTION_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/maintain/corrected_model.h"
#include "mle/maintain/estimation.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/fopdt_fit.h"
#include "mle/nonlinear/sopdt_fit.h"

namespace mle {

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

}  // namespace mle

#endif  // MLE_MAINTAIN_FOPDT_DESCRIPTION_H_
