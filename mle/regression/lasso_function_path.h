// A path from a solver of single λ. Internal to mle/regression.

#ifndef MLE_REGRESSION_LASSO_FUNCTION_PATH_H_
#define MLE_REGRESSION_LASSO_FUNCTION_PATH_H_

#include "absl/status/status.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

// Fills path, gaps and report of `solution` for its λ (ascending). The path is
// straight between knots, so that λ whose interpolated solution has a relative
// gap of at most 1e-9 need no solve.
absl::Status SolveByFunction(const LassoObjective& objective,
                             const LassoFunction& function,
                             LassoSolution& solution);

}  // namespace mle

#endif  // MLE_REGRESSION_LASSO_FUNCTION_PATH_H_
