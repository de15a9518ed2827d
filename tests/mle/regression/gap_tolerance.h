// How small a duality gap can be asked for.

#ifndef TESTS_MLE_REGRESSION_GAP_TOLERANCE_H_
#define TESTS_MLE_REGRESSION_GAP_TOLERANCE_H_

#include <algorithm>
#include <limits>

#include "Eigen/Core"
#include "mle/regression/lasso_problem.h"

namespace mle {

// 1e-9, and what the rounding of β alone costs: with β rounded, c_j is off by
// ε Σ_i |G_ji β_i| ≤ ε √G_jj Σ_i √G_ii |β_i|, and the relative gap by about
// that over λw_j, a few times over.
inline double GapTolerance(const LassoObjective& objective, double lambda,
                           const Eigen::VectorXd& beta) {
  if (lambda == 0.0) return 1e-9;
  const Eigen::VectorXd root = objective.gram->diagonal().cwiseSqrt();
  double greatest = 0.0;
  for (int j = 0; j < objective.size(); ++j) {
    const double w = objective.weights(j);
    if (w > 0.0) greatest = std::max(greatest, root(j) / w);
  }
  const double rounding =
      objective.LambdaMax() + greatest * root.dot(beta.cwiseAbs());
  return 1e-9 +
         16.0 * std::numeric_limits<double>::epsilon() * rounding / lambda;
}

}  // namespace mle

#endif  // TESTS_MLE_REGRESSION_GAP_TOLERANCE_H_
