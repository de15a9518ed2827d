// The linearly independent ones among the regressors without penalty.

#ifndef MLE_REGRESSION_UNPENALISED_H_
#define MLE_REGRESSION_UNPENALISED_H_

#include <vector>

#include "mle/regression/lasso_problem.h"
#include "mle/regression/updatable_cholesky.h"

namespace mle {

// Regressors with w_j = 0, in ascending order, but for those in the span of the
// ones before them: whose squared distance from it is at most 1e-12 of their
// square, where the Gram matrix begins to be rounding. The path keeps the
// coefficients of these at zero, and its certificate asks nothing of their c_j.
// `factor`, empty before, becomes that of G_FF.
std::vector<int> IndependentUnpenalised(const LassoObjective& objective,
                                        UpdatableCholesky& factor);

}  // namespace mle

#endif  // MLE_REGRESSION_UNPENALISED_H_
