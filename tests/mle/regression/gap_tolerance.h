// How small a duality gap can be asked for.

#ifndef TESTS_MLE_REGRESSION_GAP_TOLERANCE_H_
#define TESTS_MLE_REGRESSION_GAP_TOLERANCE_H_

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "Eigen/Core"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/unpenalised.h"
#include "mle/regression/updatable_cholesky.h"

namespace mle {

// 1e-9, and what the rounding of β alone costs: with β rounded, c_j is off by
// e_j = ε (|C_j| + Σ_i |G_ji β_i|) ≤ ε (|C_j| + √G_jj Σ_i √G_ii |β_i|), and the
// relative gap by about that over λw_j, a few times over. Regressors F without
// penalty hand theirs on: the dual point is orthogonal to them, which changes
// c_j by (G_jF G_FF⁻¹) c_F.
inline double GapTolerance(const LassoObjective& objective, double lambda,
                           const Eigen::VectorXd& beta) {
  if (lambda == 0.0) return 1e-9;
  const Eigen::MatrixXd& gram = *objective.gram;
  const Eigen::VectorXd root = gram.diagonal().cwiseSqrt();
  const Eigen::VectorXd error =
      objective.correlation.cwiseAbs() + root.dot(beta.cwiseAbs()) * root;
  UpdatableCholesky factor(1);
  const std::vector<int> free = IndependentUnpenalised(objective, factor);
  double rounding = 0.0;
  for (int j = 0; j < objective.size(); ++j) {
    const double w = objective.weights(j);
    if (!(w > 0.0) || !std::isfinite(w)) continue;
    Eigen::VectorXd handed_on = gram.col(j)(free);
    factor.SolveInPlace(handed_on);
    const double all = error(j) + handed_on.cwiseAbs().dot(error(free));
    rounding = std::max(rounding, all / w);
  }
  return 1e-9 +
         16.0 * std::numeric_limits<double>::epsilon() * rounding / lambda;
}

}  // namespace mle

#endif  // TESTS_MLE_REGRESSION_GAP_TOLERANCE_H_
