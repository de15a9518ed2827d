// Fits of elements of low order to a sampled step response y_k, k = 0 … N.
//
// A first-order element with dead time:
//
//   min over K, T, L of Σ_k (y_k − h(kΔt))²,
//   h(t) = K (1 − e^{−(t−L)/T}) for t > L, else 0.
//
// K is the static gain (output per input), T > 0 the time constant and L ≥ 0
// the dead time, both in the unit of Δt. The dead time need not be a multiple
// of Δt.
//
// The objective has kinks in L at every sample and, with noise, many local
// minima. For a fixed T and for L within one sample it is linear in two
// unknowns, so that a search over T finds the best L of every sample in closed
// form (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973).
// Levenberg–Marquardt then polishes the best of them within its sample.
//
//   MLE_ASSIGN_OR_RETURN(const FopdtFit fit,
//                        FitFopdt(response.element(0, 1), 0.2, {}));
//   if (fit.shape == FopdtShape::kFits) use(fit.gain, fit.delay);
//
// A second-order element with dead time:
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

#ifndef MLE_NONLINEAR_LOW_ORDER_FIT_H_
#define MLE_NONLINEAR_LOW_ORDER_FIT_H_

#include <limits>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle {

struct FopdtOptions {
  // L ≤ max_delay, in the unit of Δt, ≥ 0. L never exceeds (N − 3) Δt either,
  // so that three samples see the response.
  double max_delay = std::numeric_limits<double>::infinity();
  // T ≥ min_time_constant_samples · Δt, > 0. A faster element has settled
  // within a sample, and is indistinguishable from a jump.
  double min_time_constant_samples = 0.05;
  // T ≤ max_time_constant_horizons · NΔt, ≥ 1. A slower element is
  // indistinguishable from an integrator.
  double max_time_constant_horizons = 100.0;
  // A response that stays within ± this is negligible; in units of the
  // output, ≥ 0. The default is far below any gain and above rounding.
  double negligible_response = 1e-9;
  // The fit is poor where the residuals exceed these fractions of the
  // response's range (its largest less its smallest value): their root mean
  // square the first, the largest of them the second; > 0. A lag of second
  // order stays below both; an inverse response or an overshoot does not.
  double poor_relative_rms = 0.05;
  double poor_relative_residual = 0.2;
  // Local minima along a grid of T that are searched more closely, ≥ 1.
  int num_starts = 3;
  // Most iterations of each of the three solves that polish, ≥ 1.
  int max_iterations = 200;

  absl::Status Validate() const;
};

enum class FopdtShape {
  kFits,
  // The response is negligible: gain, time constant and dead time are 0, and
  // the last two mean nothing.
  kNoResponse,
  // The values are those of the best fit, but the response has another shape:
  // residuals beyond the options' fractions (inverse response, oscillation,
  // mere noise), T at its upper bound (integrating), or a gain smaller than its
  // standard error.
  kPoorFit,
};

enum class FopdtTermination { kNotRun, kConverged, kIterationLimit, kFailed };

struct FopdtFit {
  double gain = 0.0;           // K
  double time_constant = 0.0;  // T
  double delay = 0.0;          // L

  // From the residual variance and the Jacobian, as if the residuals were
  // independent: those of a model's response are not, and then the errors are
  // larger. Infinite where the response does not determine the parameter.
  double gain_standard_error = std::numeric_limits<double>::infinity();
  double time_constant_standard_error = std::numeric_limits<double>::infinity();
  double delay_standard_error = std::numeric_limits<double>::infinity();

  // Relative to the response's range.
  double relative_rms = std::numeric_limits<double>::infinity();
  double relative_max_residual = std::numeric_limits<double>::infinity();

  FopdtShape shape = FopdtShape::kPoorFit;
  FopdtTermination termination = FopdtTermination::kNotRun;
  int iterations = 0;  // Of the three solves together.
};

// InvalidArgument if an option is out of range, Δt is not positive, or the
// response has fewer than five samples or a value that is not finite.
absl::StatusOr<FopdtFit> FitFopdt(
    const Eigen::Ref<const Eigen::VectorXd>& step_response, double sample_time,
    const FopdtOptions& options);

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

#endif  // MLE_NONLINEAR_LOW_ORDER_FIT_H_
