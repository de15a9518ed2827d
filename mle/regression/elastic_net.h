// The elastic net for a fixed ratio ρ of its two penalties,
//
//   minimise ½ βᵀGβ − Cᵀβ + ½v + λ (ρ Σ_j w_j |β_j| + ½ (1 − ρ) Σ_j β_j²),
//
// which shares a coefficient among collinear regressors instead of picking one.
// (Zou and Hastie, J. R. Stat. Soc. B 67, 2005; the paper's outlook.)
//
// It is the lasso with penalty λρ on G + λ(1 − ρ)I. As λ falls that matrix
// changes too, so that the path is no longer piecewise linear: every λ is
// solved by itself, from the solution before it, by an active-set search that
// ends at the exact minimiser after finitely many steps (feature-sign search:
// Lee, Battle, Raina and Ng, NIPS 2006). Between the λ of the grid the path is
// interpolated.

#ifndef MLE_REGRESSION_ELASTIC_NET_H_
#define MLE_REGRESSION_ELASTIC_NET_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

struct ElasticNetOptions {
  double ratio = 0.5;       // ρ, 0 < ρ ≤ 1; 1 is the lasso
  double tolerance = 1e-9;  // relative duality gap to reach at each λ, > 0
  int max_steps = 10000;    // of the search at one λ, ≥ 1

  absl::Status Validate() const;
};

// Solutions and relative duality gaps at every λ of `lambdas` (ascending, > 0).
// Each costs |A|³/3 operations a step; most need a step or two.
absl::StatusOr<LassoSolution> SolveElasticNet(const LassoObjective& objective,
                                              const Eigen::VectorXd& lambdas,
                                              const ElasticNetOptions& options);

}  // namespace mle

#endif  // MLE_REGRESSION_ELASTIC_NET_H_
