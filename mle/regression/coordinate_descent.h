// The lasso at one λ by cyclic coordinate descent on the Gram matrix.
//
// Minimises f along one coefficient after the other,
//
//   β_j ← S(c_j + G_jj β_j, λw_j) / G_jj,   S(x, a) = sign(x) (|x| − a)₊,
//
// sweeping over the coefficients that are not zero until they settle and over
// all of them then. (Friedman, Hastie and Tibshirani, J. Stat. Softw. 33(1),
// 2010.) On strongly collinear columns it needs very many sweeps; it serves
// where the homotopy stops early, and for comparison.

#ifndef MLE_REGRESSION_COORDINATE_DESCENT_H_
#define MLE_REGRESSION_COORDINATE_DESCENT_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/lasso_options.h"
#include "mle/regression/lasso_problem.h"

namespace mle {

struct CoordinateDescentSummary {
  bool converged = false;
  int sweeps = 0;
  Eigen::VectorXd beta;  // n
  DualityGap gap;        // of beta, whatever the stop
};

// From `start` (n, or empty for zero), without what is excluded. λ ≥ 0. Where G
// has a negative eigenvalue, f may have no minimum: diverging sweeps return
// to the start, not converged.
absl::StatusOr<CoordinateDescentSummary> SolveCoordinateDescent(
    const LassoObjective& objective, double lambda,
    const Eigen::VectorXd& start, const CoordinateDescentOptions& options);

}  // namespace mle

#endif  // MLE_REGRESSION_COORDINATE_DESCENT_H_
