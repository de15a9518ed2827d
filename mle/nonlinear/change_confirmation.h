// Which elements have changed, from those that Wald's test names, by the
// likelihood of fits in which they have and have not. Internal to
// mle/nonlinear.
//
// Wald's test measures a change by the curvature at the estimate. Of an element
// whose lag and dead time the records hardly tell from each other −2 ln L is
// flat, and far from a quadratic, between the two: where T has come out at a
// fraction of what it was and L longer by as much, the curvature there calls
// the same response a change with p = 1e-30. The likelihood ratio compares the
// responses themselves. With S(A) the squares of the whitened residuals,
// minimised over K, T and L of the elements in A, all others at their initial
// values, the element with the smallest
//
//   [S(A \ {j}) − S(A)] / r,   χ² with 3 degrees of freedom if j is as it was,
//
// leaves A as long as that is below its critical value. Fits begin at the
// estimate and at the initial values, and the better one counts; the noise is
// that of the fit with all elements free.
//
// The changed elements must account for the records: while the fit with all
// elements free is better than chance makes it, the element is added that makes
// the likeliest fit of the three whose gains alone would explain most. Where
// inputs move together the errors of all elements are large, and Wald's test
// names none of them although the records rule out the initial model.
//
// Where inputs move together, the estimate with all elements free shares what
// one element did among others, and of elements that leave one by one the wrong
// ones may stay. So elements that are added and leave in this way from none on,
// whatever is named, are a rival: a set B stands in place of A where
//
//   [S(B) − S(A)] / r < c (|A| − |B|) − 6,   |B| ≤ |A|,
//
// c the critical value of one, and 6 being a log-likelihood ratio of 3.
//
// Elements that are certain to have changed belong to every set, and do not
// leave.
//
// Where sets are compared, of those that are added and of rivals, S/r has
// besides what makes the size of a change improbable (change_prior.h): of
// changes that explain the records equally the smaller ones are taken. Tests
// are of S alone.
//
// Each record has free responses of its own, and as many amplitudes as these
// are independent: of elements with nearly equal time constants one, where
// these are moved apart two. What an amplitude more explains of noise is r in
// each record, so that their difference is added to the degrees of freedom.

#ifndef MLE_NONLINEAR_CHANGE_CONFIRMATION_H_
#define MLE_NONLINEAR_CHANGE_CONFIRMATION_H_

#include <vector>

#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

// A fit of all elements under one assumption about the noise.
struct AssumedFit {
  double weight = 1.0;  // > 0; those of all assumptions add up to 1
  const OutputFit* fit = nullptr;
};

struct ConfirmedChanges {
  std::vector<bool> changed;  // m
  // m: of each element that was named, or is its rival, the likelihood ratio
  // when it left, or the last; 0 for others.
  std::vector<double> statistics;
  std::vector<double> p_values;  // the same; 1 for others, 0 for certain ones
  // The best fit of what has changed, by the heaviest assumption.
  OutputPoint point;
  // Found from the initial values, better than from the estimate by r, or of
  // elements that were not named.
  bool restarted = false;
};

// Finds the changed elements. They may be others than those that are `named`,
// which may be none, but for those that are `certain`, some of them. Likelihood
// ratios under several assumptions are S = −2 ln Σ w exp(−S_w/2), as in the
// test of no change. An element has changed where p < `false_alarm`.
ConfirmedChanges ConfirmChanges(const OutputSetup& setup,
                                const std::vector<AssumedFit>& fits,
                                const std::vector<bool>& named,
                                const std::vector<bool>& certain,
                                double false_alarm,
                                const OutputErrorOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_CHANGE_CONFIRMATION_H_
