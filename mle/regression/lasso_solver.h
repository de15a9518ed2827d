// One lasso problem for every λ of a grid, certified.
//
// The homotopy goes as far as it can; where it stops, or where coordinate
// descent is asked for, that takes the λ that remain with warm starts, one
// after the other, and the path between them is interpolated. A solver given as
// a function is asked for those λ only between which the interpolated path is
// not certified.

#ifndef MLE_REGRESSION_LASSO_SOLVER_H_
#define MLE_REGRESSION_LASSO_SOLVER_H_

#include <functional>
#include <string>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/regression/coordinate_descent.h"
#include "mle/regression/lasso_path.h"
#include "mle/regression/lasso_problem.h"

namespace mle {

enum class LassoSolver {
  kHomotopy,
  kCoordinateDescent,
  kFunction,
  kElasticNet  // not the lasso: elastic_net.h
};

// β (n) at one λ ≥ 0, from a start nearby (n). Fails where a solve does.
using LassoFunction = std::function<absl::StatusOr<Eigen::VectorXd>(
    const LassoObjective& objective, double lambda,
    const Eigen::VectorXd& start)>;

struct LassoSolverOptions {
  LassoSolver solver = LassoSolver::kHomotopy;
  CoordinateDescentOptions coordinate_descent;
  LassoFunction function;  // of kFunction; may be called by several threads
  // ρ of kElasticNet, 0 < ρ ≤ 1. Its λ must be above 0, and its gap is that of
  // the elastic net.
  double elastic_net_ratio = 0.5;
};

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
