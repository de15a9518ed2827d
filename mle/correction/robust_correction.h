// A correction's ΔR refitted with a robust loss:
//
//   minimise  s²/N Σ_k ρ((e_k − b₀ − bᵀx_k)/s) + λ Σ_j w_j |β_j|
//
// over β (b in the units of the problem) and the intercepts b₀, output by
// output, at given λ. s is a robust scale of the residuals, ρ Huber's or
// Cauchy's (robust_loss.h); the quadratic loss of CorrectModel() is ρ = x²/2.
//
// Solved by lasso problems with weighted rows, each a smooth problem for Ceres
// from the one before (smoothed_lasso.h), until the weights converge. At the
// end the weights are computed once more, and the certificate is the duality
// gap of β in the lasso with these weights: where it is 0, β minimises a
// quadratic that touches the robust loss, so that it is stationary there, and
// for Huber's, which is convex, a minimum.
//
// Outliers of the outputs are in the regressors of the next d rows as well,
// where no loss on residuals reaches them: they are to be replaced first
// (output_reconstruction.h). The robust loss adds that rows which are still
// wrong are down-weighted.
//
//   MLE_ASSIGN_OR_RETURN(
//       const RobustCorrection robust,
//       CorrectRobustly(correction, correction.selection().lambda_star, {}));

#ifndef MLE_CORRECTION_ROBUST_CORRECTION_H_
#define MLE_CORRECTION_ROBUST_CORRECTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/correction/correction.h"
#include "mle/model/arx_model.h"
#include "mle/nonlinear/robust_loss.h"
#include "mle/nonlinear/smoothed_lasso.h"

namespace mle {

struct RobustCorrectionOptions {
  RobustLoss loss = RobustLoss::kHuber;
  // Weights stay where none moves by more than this, in (0, 1).
  double weight_tolerance = 1e-6;
  int max_rounds = 200;  // ≥ 1
  SmoothedLassoOptions lasso;

  absl::Status Validate() const;
};

// The fit of one output.
struct RobustFit {
  bool converged = false;      // the weights stay
  double scale = 0.0;          // s
  double weight_change = 0.0;  // at the last
  double relative_gap = 0.0;   // with the weights of the final residuals
  int down_weighted_rows = 0;  // of weight below 0.5
  int rounds = 0;
  SmoothedLassoSummary lasso;  // the last
};

struct RobustCorrection {
  ArxModel model;               // R + ΔR
  std::vector<RobustFit> fits;  // p

  double MaxRelativeGap() const;
};

// `lambdas`: one for each output (p, ≥ 0). Begins at the correction's own ΔR.
absl::StatusOr<RobustCorrection> CorrectRobustly(
    const Correction& correction, const Eigen::VectorXd& lambdas,
    const RobustCorrectionOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_ROBUST_CORRECTION_H_
