// The exact lasso path by homotopy.
//
// From λ_max on, where β = 0, λ falls and the solution moves on straight lines:
// on the active set A with signs s the conditions c_A = λ (s∘w)_A give
//
//   β_A(λ − t) = β_A(λ) + t q,  q = G_AA⁻¹ (s∘w)_A,
//   c(λ − t) = c(λ) − t G_·A q,
//
// until a coefficient reaches zero and leaves or an inactive c_j reaches ±λw_j
// and enters (a knot). (Osborne, Presnell and Turlach, IMA J. Numer. Anal. 20,
// 2000; Efron, Hastie, Johnstone and Tibshirani, Ann. Stat. 32, 2004.)
//
// How it stays exact on nearly dependent columns:
// - β and c are computed anew at every knot from the factor and G, with
//   iterative refinement, so that nothing drifts. Where a set is so nearly
//   dependent that a variable would leave at a blurred place, β is refined from
//   c_A in twice the working precision.
// - Events are chosen by the direction in which a slack moves; a slack already
//   used up gives a step of zero. The variable that moved last sits out one
//   step.
// - A column in the span of A cannot enter. If its c_j just follows the bound
//   (a twin of an active column) it waits until A loses a member; if it would
//   cross the bound it takes the place of the active variable that reaches zero
//   first on the line along which the fit does not change.
// - Where β shrinks along a segment, rounding of its larger values would be
//   seen at the end. From where it would be, knots are at most a factor of ten
//   apart.
// - Ties are resolved one at a time, the lowest number first once steps of zero
//   repeat, and a path that cannot go on says so and where.
//
// At λ = 0 the path ends in its limit: among the least-squares solutions one of
// smallest Σ w_j |β_j|.

#ifndef MLE_REGRESSION_HOMOTOPY_H_
#define MLE_REGRESSION_HOMOTOPY_H_

#include <limits>
#include <string>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/regression/lasso_path.h"
#include "mle/regression/lasso_problem.h"

namespace mle {

struct HomotopyOptions {
  // The path stops here; ≥ 0.
  double lambda_min = 0.0;
  // It also stops before more coefficients than this would be active; ≥ 1.
  int max_active = std::numeric_limits<int>::max();
  // λ, ascending, at which the duality gap of the path's β is computed on the
  // way.
  Eigen::VectorXd certify_at;

  absl::Status Validate() const;
};

enum class HomotopyTermination {
  kNotRun,
  kReachedLambdaMin,
  kReachedMaxActive,
  // Steps of zero kept repeating.
  kStalled,
  // The optimality conditions no longer hold after refactoring: to 1e-6 λ on
  // active columns, to 1e-4 λ on others.
  kIllConditioned,
};

struct HomotopySummary {
  HomotopyTermination termination = HomotopyTermination::kNotRun;
  LassoPath path;
  // Relative duality gap at each λ of certify_at; ∞ where the path did not
  // reach.
  Eigen::VectorXd relative_gap;
  int entered = 0;
  int left = 0;
  int exchanged = 0;   // a dependent column took an active one's place
  int refined = 0;     // knots that needed iterative refinement
  int refactored = 0;  // factors built anew
  int max_active = 0;
  // Upper bound of 1/cond(G_AA) at the end of the path.
  double reciprocal_condition_bound = 0.0;

  double MaxRelativeGap() const;
  // One line.
  std::string BriefReport() const;
};

// Fails on an invalid objective or options only.
absl::StatusOr<HomotopySummary> SolveHomotopy(const LassoObjective& objective,
                                              const HomotopyOptions& options);

}  // namespace mle

#endif  // MLE_REGRESSION_HOMOTOPY_H_
