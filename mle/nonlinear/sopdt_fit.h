// Fit of a second-order element with dead time to a sampled step response y_k,
// k = 0 … N − 1:
//
//   min over K, T, ζ, L of Σ_k (y_k − K φ((kΔt − L)/T; ζ))²,
//   g(s) = K e^{−Ls} / (T² s² + 2ζT s + 1),
//
// φ(x; ζ) = 1 − (cos wx + ζ/w sin wx) e^{−ζx} with w² = 1 − ζ² for x > 0, else
// 0: two lags T(ζ ± √(ζ² − 1)) for ζ ≥ 1, an oscillation below. No lead: an
// inverse response is not described.
//
// Starts are the best of a grid of T, ζ and L, each with its best K;
// Levenberg–Marquardt goes on from the three best, derivatives by K, ln T and L
// in closed form, by ln ζ by differences. The objective has no kinks: φ and its
// slope are continuous.
//
//   MLE_ASSIGN_OR_RETURN(const SopdtFit fit,
//                        FitSopdt(step, 0.2, /*max_delay=*/10.0));
//   if (fit.largest_difference < 0.02) use(fit.gain, fit.damping);

#ifndef MLE_NONLINEAR_SOPDT_FIT_H_
#define MLE_NONLINEAR_SOPDT_FIT_H_

#include <limits>

#include "Eigen/Core"
#include "absl/status/statusor.h"

namespace mle {

struct SopdtFit {
  double gain = 0.0;           // K, output per input
  double time_constant = 0.0;  // T > 0, in the unit of Δt
  double damping = 0.0;        // ζ, from 0.01 to 20
  double delay = 0.0;          // L, from 0 to max_delay
  // max_k |y_k − fit| relative to the range of the response, its largest less
  // its smallest value with 0 among them: the gain, without overshoot.
  double largest_difference = std::numeric_limits<double>::infinity();
};

// InvalidArgument where Δt is not positive, max_delay is negative or not
// finite, or the response has fewer than ten samples, a value that is not
// finite, or no value but 0.
absl::StatusOr<SopdtFit> FitSopdt(
    const Eigen::Ref<const Eigen::VectorXd>& step_response, double sample_time,
    double max_delay);

}  // namespace mle

#endif  // MLE_NONLINEAR_SOPDT_FIT_H_
