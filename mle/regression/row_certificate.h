// Duality gaps from the rows of a regression, not from its Gram matrix.
//
// G and C are sums that are rounded. Where regressors are nearly dependent and
// β is large, c = C − Gβ is off by that rounding times β, which at small λ is
// more than λ itself: a gap computed from G is then that of another problem.
// Here the residual r = ẽ − X̃ᵀβ is computed row by row in twice the working
// precision, and c = X̃r/N from it; the gap (duality_gap.h) takes each c_j with
// the rounding that is left,
//
//   |δc_j| ≤ 8 ε √(‖r‖²/N) √(Σ_k x_jk²/N) / scale_j.
//
// The rows cost N (n + 20|A|) operations for a λ. They are therefore gone
// through where a bound of what the rounding of G adds to the relative gap,
//
//   2 D/λ · λ Σ w_j|β_j| / P + (D/λ)²,
//   D = max_j 2ε √(N + n) m_j (m_e + Σ_i m_i |β_i|) / w_j,
//
// is not small; m are root mean squares of the rows over the scales and P the
// primal value. Where it is, it is added. Of a grid with more than 12
// values of λ to be looked at, some 12 are, and the largest difference of c
// found at the neighbours, doubled, takes the place of D at those between;
// where that is not enough, up to 100 more are looked at.

#ifndef MLE_REGRESSION_ROW_CERTIFICATE_H_
#define MLE_REGRESSION_ROW_CERTIFICATE_H_

#include "Eigen/Core"
#include "absl/types/span.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/lagged_moments.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

// The gap of β (n) at λ > 0 for response `response` of the problem that
// MakeLassoProblem() made of these rows; its scales are taken for exact.
DualityGap GapOfRows(absl::Span<const RegressionRows> rows,
                     const LassoProblem& problem, int response,
                     const LassoObjective& objective, double lambda,
                     const Eigen::VectorXd& beta);

// Makes the relative gaps of `solution` at λ > 0 those of the rows. Where they
// are above 1e-9 and those of the Gram matrix were not, the report says that λ
// is beyond double precision.
void CertifyByRows(absl::Span<const RegressionRows> rows,
                   const LassoProblem& problem, int response,
                   const LassoObjective& objective, LassoSolution& solution);

}  // namespace mle

#endif  // MLE_REGRESSION_ROW_CERTIFICATE_H_
