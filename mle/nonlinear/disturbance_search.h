// Disturbances of one output that have a form, beside its noise: periodic lines
// (line_search.h) and steps of its level (step_search.h), found one by one by
// likelihood and fitted as free amplitudes with everything else. Internal to
// mle/nonlinear.

#ifndef MLE_NONLINEAR_DISTURBANCE_SEARCH_H_
#define MLE_NONLINEAR_DISTURBANCE_SEARCH_H_

#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

// Prices in −2 ln L of a sinusoid's amplitudes in each segment and its
// frequency, and of a step's size, place and lag.
double LinePrice(const OutputErrorProblem& problem);
double StepPrice(const OutputErrorProblem& problem);

// Lines and steps added to `problem` one by one (at most three lines, and three
// steps of a segment), and `fit` made again with each; where its residuals show
// none, those of the initial values `start` are asked, and the fit from there
// with what they show is compared by likelihood. None without
// options.estimate_drift.
void FitDisturbances(const OutputPoint& start, const OutputFitBounds& bounds,
                     const OutputErrorOptions& options,
                     OutputErrorProblem& problem, OutputFit& fit);

}  // namespace mle

#endif  // MLE_NONLINEAR_DISTURBANCE_SEARCH_H_
