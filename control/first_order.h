// The gain, time constant and dead time that tuning rules ask for, read from a
// step response. Of one that settles by Smith's two points: with t₂₈ and t₆₃
// the times at which it first reaches 28.3 % and 63.2 % of its final value,
//
//   T = 1.5 (t₆₃ − t₂₈),  L = max(0, t₆₃ − T),
//
// exact for a first-order element with dead time up to the sampling. (C. L.
// Smith, Digital Computer Process Control, 1972; Seborg, Edgar, Mellichamp and
// Doyle, Process Dynamics and Control, 2011, sec. 7.2.) Of one that ends in a
// ramp: K is its slope, the ramp meets 0 at t₀ = L + T, and
//
//   T = e φ(t₀)/K, within [0, t₀],
//
// exact for K e^(−Ls) / (s (T s + 1)) up to the sampling. A rough description
// of a response of any shape, made for choosing horizons; for a fit see
// mle/nonlinear/low_order_fit.h.

#ifndef CONTROL_FIRST_ORDER_H_
#define CONTROL_FIRST_ORDER_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/model/step_response.h"

namespace mle::control {

struct FirstOrder {
  double gain = 0.0;           // K; 0: the input does not reach the output
  double time_constant = 0.0;  // T ≥ 0
  double delay = 0.0;          // L ≥ 0
  bool integrating = false;
};

// Row by row (p·m). Responses that stay within 1 % of the largest of their
// output and of their input are taken as zero. InvalidArgument for no samples
// or values that are not finite.
absl::StatusOr<std::vector<FirstOrder>> DescribeAsFirstOrder(
    const StepResponse& response);

}  // namespace mle::control

#endif  // CONTROL_FIRST_ORDER_H_
