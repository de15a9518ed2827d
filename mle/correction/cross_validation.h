// Choice of the penalty by cross-validation.
//
// Every fold is predicted by a fit to all the others; λ* minimises the sum of
// the folds' prediction losses over all outputs. Exact: the loss is a piecewise
// quadratic in λ along each path (validation_loss.h).

#ifndef MLE_CORRECTION_CROSS_VALIDATION_H_
#define MLE_CORRECTION_CROSS_VALIDATION_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "mle/correction/regression_data.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

struct SelectionOptions {
  enum class Rule {
    // A fold is a window, that is, a set-point change (the paper's rule).
    kLeaveChangeOut,
    // Every window is cut into blocks that are dealt out to the folds, so that
    // each fit has seen every change.
    kBlocks,
  };
  Rule rule = Rule::kLeaveChangeOut;
  int folds = 5;           // of kBlocks, ≥ 2
  int block_length = 300;  // of kBlocks, in samples, ≥ 1

  absl::Status Validate() const;
};

struct CrossValidationSummary {
  // Sum of the folds' losses at each λ of the grid; with the fits' penalties
  // λ Σ|β| added (the paper's Eq. 6 read literally).
  Eigen::VectorXd loss;
  Eigen::VectorXd penalised_loss;
  // The grid's λ of the smallest loss, the larger of two; likewise penalised.
  double lambda_star = 0.0;
  double lambda_star_penalised = 0.0;
  // Over all λ ≥ 0 rather than the grid.
  double lambda_exact = 0.0;
  // Relative duality gap, the worst of all fits and λ of the grid.
  double max_relative_gap = 0.0;
};

// `lambdas` ascending, ≥ 0. Needs at least two folds.
absl::StatusOr<CrossValidationSummary> CrossValidate(
    const RegressionData& data, Scaling scaling, const Eigen::VectorXd& lambdas,
    const SelectionOptions& selection, const LassoSolverOptions& solver);

}  // namespace mle

#endif  // MLE_CORRECTION_CROSS_VALIDATION_H_
