// Steps of one output's level at unknown times. Internal to mle/nonlinear.
//
//   c (1 − exp(−(k − t + 1)/T)) at the samples k ≥ t of a segment, c if T = 0:
//
// at once, or as a step of a load at an input is behind the lag of its element.
//
//   1. For residuals n of a fit whose noise has the covariance rV, the score
//      of a column x is xᵀV⁻¹n, and V⁻¹n is the smoothed white part of n
//      (innovations_filter.h): the scores of all t are sums from t on, one pass
//      for each T. Their variances r (xᵀV⁻¹x less what is fitted besides
//      explains) are taken at some t and interpolated. T is 0 or the time scale
//      of one of the elements. The largest score is looked at where its χ²
//      exceeds 2 ln N.
//   2. Place and T move by likelihood, the noise shape estimated beside them: a
//      walk that follows the step must not hide it.
//   3. The step counts where −2 ln L falls by more than 3 ln N (its size by
//      Schwarz, its place among N samples) and by more than the inputs explain
//      (line_search.h).

#ifndef MLE_NONLINEAR_STEP_SEARCH_H_
#define MLE_NONLINEAR_STEP_SEARCH_H_

#include <optional>
#include <vector>

#include "mle/nonlinear/extended_fit.h"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {

// Each T of the above, in samples: 0 and the time scales of the elements, those
// that are near to each other once.
std::vector<double> StepLags(const OutputErrorProblem& problem,
                             const OutputPoint& point);

struct FoundStep {
  SegmentStep step;
  double gain = 0.0;  // of −2 ln L beyond its price, > 0
};

// The step that the residuals of the fit show; what its problem has already is
// fitted beside it.
std::optional<FoundStep> FindStep(const ExtendedFit& extended);

}  // namespace mle

#endif  // MLE_NONLINEAR_STEP_SEARCH_H_
