// The prediction loss of a lasso path on other rows.
//
// A fit on one set of rows predicts e ≈ ē + Σ_j β_j (x_j − x̄_j) / s_j with the
// means and scales of that set. On N_v other rows its loss
//
//   V(λ) = 1/(2N_v) Σ_k (e_k − ê_k(λ))²
//
// is a quadratic in β and so piecewise quadratic in λ along the path: it needs
// the moments of the other rows only, and is exact for every λ. Where the rows
// are in groups with a mean each, a group that the fit has not seen is
// predicted about its own mean.

#ifndef MLE_REGRESSION_VALIDATION_LOSS_H_
#define MLE_REGRESSION_VALIDATION_LOSS_H_

#include "Eigen/Core"
#include "mle/regression/lagged_moments.h"
#include "mle/regression/lasso_path.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/piecewise_quadratic.h"

namespace mle {

// Validation rows in the units of the problem that was fitted.
class ValidationRows {
 public:
  ValidationRows(const LassoProblem& fitted, const LaggedMoments& validation);

  // V along `path`, a path of response `response` of the fitted problem.
  PiecewiseQuadratic Loss(const LassoPath& path, int response) const;

 private:
  Eigen::MatrixXd gram_;             // n × n
  Eigen::MatrixXd correlation_;      // n × q
  Eigen::VectorXd response_square_;  // q
};

// λ Σ_j w_j |β_j(λ)| along a path; `weights` (n) must be finite where β ≠ 0.
PiecewiseQuadratic PenaltyAlong(const LassoPath& path,
                                const Eigen::VectorXd& weights);

}  // namespace mle

#endif  // MLE_REGRESSION_VALIDATION_LOSS_H_
