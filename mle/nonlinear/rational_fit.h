// A transfer function of low order with dead time for a sampled step response
// y_k, k = 0 … N, of any shape:
//
//   g(s) = e^{−Ls} Σ_i c_i / (τ_i s + 1),   i = 1 … n,
//
// least squares over c_i, τ_i > 0 and L, with the smallest n that leaves no
// more than a stated share of the response, up to a largest n. Real poles of
// any sign of c_i describe lags, leads, inverse responses and overshoots, not
// oscillations.
//
//   MLE_ASSIGN_OR_RETURN(const RationalFit fit,
//                        FitRational(step, 0.2, RationalOptions()));
//   use(fit.element, fit.relative_error);
//
// For each L on a grid, poles are added one at a time from a grid of time
// constants, each the best beside those before (orthogonal matching pursuit:
// Pati, Rezaiifar and Krishnaprasad, Asilomar 1993); then τ_i and L are moved
// by steps that shrink until none is better.

#ifndef MLE_NONLINEAR_RATIONAL_FIT_H_
#define MLE_NONLINEAR_RATIONAL_FIT_H_

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/transfer_function.h"

namespace mle {

struct RationalOptions {
  double min_delay = 0.0;  // of L, in the unit of Δt, ≥ 0
  double max_delay = 0.0;  // ≥ min_delay
  int max_order = 5;       // n, ≥ 1
  // ‖y − fit‖ / ‖y‖ at which no pole is added, > 0.
  double tolerance = 1e-3;

  absl::Status Validate() const;
};

struct RationalFit {
  TransferFunction element;
  double relative_error = 0.0;  // ‖y − fit‖ / ‖y‖
};

// InvalidArgument if an option is out of range, Δt is not positive, or the
// response has fewer than five samples or a value that is not finite.
absl::StatusOr<RationalFit> FitRational(
    const Eigen::Ref<const Eigen::VectorXd>& step_response, double sample_time,
    const RationalOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_RATIONAL_FIT_H_
