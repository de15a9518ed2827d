// Random errors of the time stamps of an output that is measured now and then,
// as by a laboratory. Internal to mle/nonlinear.
//
// With z the simulation, δ_k the error of a stamp and n the noise,
//
//   y_k = z(t_k + δ_k) + n_k,    δ_k of mean 0 and standard deviation s.
//
// Integrated over δ_k the white part of the noise has the variance r + v_k, v_k
// the mean of (z(t_k + δ) − z(t_k))², also beside a move, where z has a kink: a
// sample has the weight r / (r + v_k) (Carroll and Ruppert, Transformation and
// Weighting in Regression, 1988). Few samples tell of s: v is its mean under
// the restricted likelihood at the fit and a prior uniform in s, up to an
// eighth of the time between samples. A constant error is a dead time.

#ifndef MLE_NONLINEAR_STAMP_NOISE_H_
#define MLE_NONLINEAR_STAMP_NOISE_H_

#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

// Leaves s and the weights in `problem`, in place of those that it has: none
// for an output whose samples are less than three sample times apart.
void FindStampNoise(const OutputFit& fit, OutputErrorProblem& problem);

}  // namespace mle

#endif  // MLE_NONLINEAR_STAMP_NOISE_H_
