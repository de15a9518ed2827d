// Choice of the penalty λ from the records alone.
//
// Cross-validation: every fold of rows is predicted by a fit to all others, and
// λ* minimises the folds' prediction losses. The rules differ in their folds
// and predictions; docs/selection.md compares them.
//
//   leave change out   a fold is a window, that is, a set-point change: the
//                      paper's rule. A fit that has never seen a direction of
//                      the inputs cannot predict it, which favours large λ.
//   blocks             windows are cut into blocks, assigned to the folds
//                      in turn, so that every fit has seen every change, and
//                      cut once more half a block later, since it matters where
//                      the cuts lie against the change. Default, with a check
//                      of the step responses.
//   AIC, BIC, GCV      from the fit to all rows and its degrees of freedom, the
//                      number of coefficients that are not zero (Zou, Hastie
//                      and Tibshirani, Ann. Stat. 35, 2007).
//
// One step ahead the loss of a path is a piecewise quadratic in λ, known
// exactly for all λ. Further ahead it is computed on a thinned grid, with λ = 0
// among it only where the smallest λ > 0 is the best of the others.
//
// Prediction losses hardly see errors of gains. So with blocks the λ of least
// loss is a proposal, which the estimated error of the step responses, Ê
// (response_risk.h), may refuse: of
//
//   no correction, the λ of least loss, the λ of least Ê
//
// λ* is the first whose Ê exceeds the least one by no more than
// `response_deviations` of its standard deviations.

#ifndef MLE_CORRECTION_SELECTION_H_
#define MLE_CORRECTION_SELECTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "mle/correction/correction_options.h"
#include "mle/correction/regression_data.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

struct SelectionSummary {
  Eigen::VectorXd lambda_star;  // p, all equal unless per_output
  // Where the loss was computed, ascending, and the folds' losses there, their
  // rows counting alike; with the fits' penalties λ Σ|β| (the paper's Eq. 6
  // read literally; empty unless one step ahead).
  Eigen::VectorXd lambdas;
  Eigen::VectorXd loss;
  Eigen::VectorXd penalised_loss;
  double lambda_star_penalised = 0.0;  // minimises penalised_loss
  // Where Ê was computed, ascending, and Ê there with its standard deviation.
  // Empty without a check, and where least squares does not determine a stable
  // model.
  Eigen::VectorXd response_lambdas;
  Eigen::VectorXd response_risk;
  double response_deviation = 0.0;
  // Relative duality gap, the worst of the folds' fits at every λ of the grid.
  double max_relative_gap = 0.0;
};

// `penalty_weights` are those of CorrectionOptions. `fits` are the solutions
// for each output of `problem`, made from all rows of `data`; `lambdas` is
// their grid.
absl::StatusOr<SelectionSummary> SelectLambda(
    const RegressionData& data, Scaling scaling,
    const Eigen::MatrixXd& penalty_weights, const LaggedMoments& moments,
    const LassoProblem& problem, absl::Span<const LassoSolution> fits,
    const SelectionOptions& options, const LassoSolverOptions& solver);

}  // namespace mle

#endif  // MLE_CORRECTION_SELECTION_H_
