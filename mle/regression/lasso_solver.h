// One lasso problem for every λ of a grid, certified.
//
// The homotopy goes as far as it can; where it stops, or where coordinate
// descent is asked for, that takes the λ that remain with warm starts, one
// after the other, and the path between them is interpolated. A solver given as
// a function is asked for those λ only between which the interpolated path is
// not certified.

#ifndef MLE_REGRESSION_LASSO_SOLVER_H_
#define MLE_REGRESSION_LASSO_SOLVER_H_

#include <string>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/regression/lasso_options.h"
#include "mle/regression/lasso_path.h"
#include "mle/regression/lasso_problem.h"

namespace mle {

struct LassoSolution {
  LassoPath path;
  Eigen::VectorXd lambdas;       // as asked for, ascending
  Eigen::VectorXd relative_gap;  // at each of them
  // How it went; where and why the homotopy stopped, if it did.
  std::string report;

  double MaxRelativeGap() const {
    return relative_gap.size() > 0 ? relative_gap.maxCoeff() : 0.0;
  }
};

// Solves down to the smallest of `lambdas` (ascending, ≥ 0, not empty). Fails
// on bad input, or if a function given fails; a gap that is too large is in the
// solution.
absl::StatusOr<LassoSolution> SolveLasso(const LassoObjective& objective,
                                         const Eigen::VectorXd& lambdas,
                                         const LassoSolverOptions& options);

}  // namespace mle

#endif  // MLE_REGRESSION_LASSO_SOLVER_H_
