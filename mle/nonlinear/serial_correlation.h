// The effect on the estimates of correlation that a noise shape leaves in the
// whitened residuals. Internal to mle/nonlinear.
//
// With e the whitened residuals of an output and J their derivatives, both less
// what the amplitudes explain, the errors of the estimates are B e,
// B = (JᵀJ)⁻¹Jᵀ, and with γ_l the autocovariances of e within segments
//
//   Cov = B Γ Bᵀ,   Γ_kl = (1 − |k − l|/(L + 1)) γ_{|k − l|}, 0 beyond L
//
// in place of r (JᵀJ)⁻¹ (Newey and West, Econometrica 55, 1987; the same as
// the expectation over surrogates that resample e in blocks of L). The mean of
// the likelihood ratio without a change is tr(P Γ)/r, P = J B, in place of its
// ν = rank J. γ_l are of the records fitted and of those at rest, where there
// are such, together. They are estimated from few numbers: what white noise
// would give in one of 40 records counts as 1.

#ifndef MLE_NONLINEAR_SERIAL_CORRELATION_H_
#define MLE_NONLINEAR_SERIAL_CORRELATION_H_

#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {

// Factors ≥ 1.
struct SerialInflation {
  double statistic = 1.0;     // of the likelihood ratio
  Eigen::VectorXd variances;  // 3m: of each parameter's variance

  // S C S with S the roots of `variances`.
  Eigen::MatrixXd Scale(const Eigen::MatrixXd& covariance) const;
};

// At the fit `point` of the elements that are `free`, from columns linearised
// there and `whitened` by `shape`. L is `longest` samples, at most a quarter of
// the shortest segment.
SerialInflation InflationOf(const OutputErrorProblem& problem,
                            const OutputPoint& point,
                            const WhitenedColumns& whitened,
                            const std::vector<bool>& free,
                            const NoiseShape& shape, int longest);

}  // namespace mle

#endif  // MLE_NONLINEAR_SERIAL_CORRELATION_H_
