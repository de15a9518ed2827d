#include "mle/correction/smoothed_correction.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/correction/cross_validation.h"

namespace mle {

double SmoothedCorrection::MaxRelativeGap() const {
  double worst = 0.0;
  for (const SmoothedLassoSummary& fit : fits) {
    worst = std::max(worst, fit.gap.Relative());
  }
  return worst;
}

absl::StatusOr<SmoothedCorrection> CorrectSmoothed(
    const Correction& correction, const Eigen::VectorXd& lambdas,
    const SmoothedLassoOptions& options) {
  SmoothedCorrection smoothed;
  smoothed.model = correction.initial();
  const int outputs = smoothed.model.num_outputs;
  if (lambdas.size() != outputs) {
    return absl::InvalidArgumentError(
        absl::StrFormat("smoothed correction: %d values of λ are given for %d "
                        "outputs; one for each is needed",
                        lambdas.size(), outputs));
  }
  for (int i = 0; i < outputs; ++i) {
    const LassoObjective objective(
        correction.problem(), i,
        PenaltyWeights(correction.penalty_weights(), i));
    MLE_ASSIGN_OR_RETURN(
        SmoothedLassoSummary fit,
        SolveSmoothedLasso(objective, lambdas(i), {}, options));
    smoothed.model.R.row(i) +=
        correction.problem().Unscale(fit.beta).transpose();
    smoothed.fits.push_back(std::move(fit));
  }
  return smoothed;
}

}  // namespace mle
