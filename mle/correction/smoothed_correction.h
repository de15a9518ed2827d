// A correction's ΔR as the smooth problem of smoothed_lasso.h, solved by Ceres
// at given λ: a check of the exact engine by one that shares only the data with
// it, and a basis for other penalties and losses.
//
//   MLE_ASSIGN_OR_RETURN(
//       const SmoothedCorrection smoothed,
//       CorrectSmoothed(correction, correction.selection().lambda_star, {}));

#ifndef MLE_CORRECTION_SMOOTHED_CORRECTION_H_
#define MLE_CORRECTION_SMOOTHED_CORRECTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/correction/correction.h"
#include "mle/model/arx_model.h"
#include "mle/nonlinear/smoothed_lasso.h"

namespace mle {

struct SmoothedCorrection {
  ArxModel model;                          // R + ΔR
  std::vector<SmoothedLassoSummary> fits;  // p

  double MaxRelativeGap() const;
};

// λ for each output (p, ≥ 0). Each output starts from zero.
absl::StatusOr<SmoothedCorrection> CorrectSmoothed(
    const Correction& correction, const Eigen::VectorXd& lambdas,
    const SmoothedLassoOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_SMOOTHED_CORRECTION_H_
