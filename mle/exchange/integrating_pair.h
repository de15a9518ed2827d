// An integrator with lag and dead time,
//
//   K e^{−Ls} / (s (T s + 1)),
//
// whose step response is nearest (least squares) to samples h_k that end in a
// ramp, by Levenberg and Marquardt's steps from several starts. Internal to
// mle/exchange.

#ifndef MLE_EXCHANGE_INTEGRATING_PAIR_H_
#define MLE_EXCHANGE_INTEGRATING_PAIR_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/transfer_function.h"

namespace mle {

// `response` (N + 1) is h_0 = 0, h_1, … at the interval Δ; L ≤ N Δ, and
// L ≥ `least_delay`, which may be negative as far as it is no bound.
// InvalidArgument where the response has no slope at its end, or ends before a
// ramp can begin.
absl::StatusOr<TransferFunction> FitIntegratingPair(
    const Eigen::VectorXd& response, double interval, double least_delay);

// The same with what it misses, which settles, as a sum of lags behind the same
// dead time (rational_fit.h): (K/s + R(s)) e^{−Ls}.
absl::StatusOr<TransferFunction> FitIntegratingLags(
    const Eigen::VectorXd& response, double interval,
    const TransferFunction& nearest, double tolerance);

}  // namespace mle

#endif  // MLE_EXCHANGE_INTEGRATING_PAIR_H_
