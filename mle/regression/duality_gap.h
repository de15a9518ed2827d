// The certificate of a lasso solution.
//
// With the gradient c = C − Gβ of the smooth part, the residual's square
// ‖r‖²/N = v − βᵀ(C + c) and the dual point r·α, α = min(1, λ / max_j
// |c_j|/w_j), primal less dual objective is
//
//   gap = ½ (1 − α)² ‖r‖²/N + Σ_j |β_j| (λ w_j − α sign(β_j) c_j) ≥ 0,
//
// a sum of small terms rather than a difference of large ones. The minimum lies
// at most `gap` below the primal value. (Kim, Koh, Lustig, Boyd and Gorinevsky,
// IEEE J. Sel. Top. Signal Process. 1(4), 2007, sec. III.)
//
// Regressors without penalty need c_j = 0; r is first made orthogonal to them
// (to the linearly independent ones: unpenalised.h).
// At λ = 0 the gap is the distance to the least-squares minimum, ½ cᵀG⁺c.

#ifndef MLE_REGRESSION_DUALITY_GAP_H_
#define MLE_REGRESSION_DUALITY_GAP_H_

#include "Eigen/Core"
#include "mle/regression/lasso_problem.h"

namespace mle {

struct DualityGap {
  double primal = 0.0;  // ½‖r‖²/N + λ Σ w_j |β_j|
  double gap = 0.0;
  // max_j (|c_j| − λw_j)₊ / w_j and, for β_j ≠ 0, |sign(β_j) c_j − λw_j| / w_j;
  // |c_j| where nothing is penalised.
  double kkt_violation = 0.0;

  double response_square = 0.0;  // v
  // The rounding error that the primal value may have (PrimalRounding).
  double primal_rounding = 0.0;

  // gap / (primal − primal_rounding), where a denominator below ε v counts as
  // ε v: no better than the gap relative to the true primal value.
  double Relative() const;
};

// The residual's square is a difference, v − βᵀ(C + c), of terms that with
// nearly dependent regressors exceed it by far. With β_j and c_j = C_j − Σ_i
// G_ji β_i rounded, |G_ji| ≤ √(G_jj G_ii), its half is known to within
//
//   ε (v + Σ_j |β_j| |C_j| + (Σ_j √G_jj |β_j|)²).
//
// This sums the two sums over j.
class PrimalRounding {
 public:
  explicit PrimalRounding(const LassoObjective& objective)
      : objective_(objective) {}

  void Add(int j, double beta);
  double Value() const;

 private:
  const LassoObjective& objective_;
  double product_ = 0.0;  // Σ_j |β_j| |C_j|
  double length_ = 0.0;   // Σ_j √G_jj |β_j|
};

// Infinite where an excluded coefficient is not zero, and where β is so large
// that its products overflow. Costs n operations for
// each coefficient that is not zero, and at λ = 0, or with unpenalised
// regressors, a factorisation.
DualityGap ComputeDualityGap(const LassoObjective& objective, double lambda,
                             const Eigen::VectorXd& beta);

// The same at λ > 0 where c and ‖r‖²/N are known from elsewhere, c_j to within
// `rounding` (n, or empty for exact).
DualityGap GapOfGradient(const LassoObjective& objective, double lambda,
                         const Eigen::VectorXd& beta, Eigen::VectorXd gradient,
                         double residual_square,
                         const Eigen::VectorXd& rounding = {});

// The least-squares solution of smallest norm, G⁺C over the regressors that are
// not excluded; the same directions count as null.
Eigen::VectorXd MinimumNormLeastSquares(const LassoObjective& objective);

// ½ cᵀG⁺c over the regressors that are not excluded, by eigenvalues; directions
// below n ε times the largest count as null.
double LeastSquaresGap(const LassoObjective& objective,
                       const Eigen::VectorXd& gradient);

}  // namespace mle

#endif  // MLE_REGRESSION_DUALITY_GAP_H_
