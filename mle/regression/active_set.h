// The active set of a regularisation path and the fit on it.
//
// At λ the active coefficients solve c_A = λ (s∘w)_A, and as λ falls by t they
// move along straight lines:
//
//   β_A(λ − t) = β_A + t q,   q = G_AA⁻¹ (s∘w)_A,
//   c(λ − t) = c − t b,       c = C − G_·A β_A,  b = G_·A q.
//
// Solutions come from an updated Cholesky factor and are refined until the
// optimality conditions hold to rounding, where need be from c_A in twice the
// working precision; the factor is built anew where that does not help.

#ifndef MLE_REGRESSION_ACTIVE_SET_H_
#define MLE_REGRESSION_ACTIVE_SET_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/updatable_cholesky.h"

namespace mle {

// Pivots below this part of a column's square are rounding.
inline constexpr double kDependentPivot = 4e-15;
// Differences below this many times the estimated rounding are rounding.
inline constexpr double kSeveralRoundings = 8.0;

class ActiveSet {
 public:
  enum class State : std::uint8_t {
    kInactive,
    kActive,
    kWaiting,   // in the span of the active columns, until one of them leaves
    kExcluded,  // an infinite weight, or a column of zeros
  };

  // `objective` must outlive the set. Columns without penalty are active at
  // once, but for those in the span of others; `Solve` is yet to come.
  explicit ActiveSet(const LassoObjective& objective);

  int size() const { return static_cast<int>(columns_.size()); }
  const std::vector<int>& columns() const { return columns_; }
  // The position of column `variable` among them.
  int PositionOf(int variable) const;
  // The first so many are without penalty; they never leave.
  int num_unpenalised() const { return num_unpenalised_; }
  State state(int variable) const { return states_[variable]; }
  void Wait(int variable) { states_[variable] = State::kWaiting; }
  int Count(State state) const;

  // By position: s w (0 without penalty), β, q.
  double target(int i) const { return target_(i); }
  double beta(int i) const { return beta_(i); }
  double slope(int i) const { return slope_(i); }
  auto betas() const { return beta_.head(size()); }
  auto slopes() const { return slope_.head(size()); }
  // By variable: c, b, and 1/w (0 without penalty or excluded).
  const Eigen::VectorXd& c() const { return c_; }
  const Eigen::VectorXd& b() const { return b_; }
  const Eigen::VectorXd& inverse_weights() const { return inverse_weights_; }

  const LassoObjective& objective() const { return objective_; }
  const UpdatableCholesky& cholesky() const { return cholesky_; }
  // max_j |C_j| / w_j.
  double scale() const { return scale_; }

  // Makes q, refines β at λ, and makes c and b. False if even after refactoring
  // the optimality conditions of active columns do not hold to 1e-6 λ, or those
  // of inactive ones, which enter at once, to 1e-4 λ.
  bool Solve(double lambda);
  // β ← β + step q; c stays that of before until `Solve`.
  void Move(double step) { beta_.head(size()) += step * slope_.head(size()); }

  // Rounding error to be expected of c_j / w_j.
  double Rounding() const;
  // The same of b_j / w_j.
  double SlopeRounding(int variable) const;
  // Whether at λ the rounding of c_A leaves it open where the coefficient of
  // `leaving` reaches zero, so that its c_j may miss its bound there.
  bool IsBlurred(int leaving, double lambda) const;
  // β and c from c_A in twice the working precision.
  void RefineSharply(double lambda);
  // c of β + step q as rounded, in twice the working precision.
  void SharpC(double step, Eigen::VectorXd& c) const;

  // Adds `variable` with s = sign unless its squared distance from the span of
  // the others is at most tolerance × its square. Returns that distance.
  double Append(int variable, double sign, double tolerance);
  // Takes `variable` out; those that wait may be tried again.
  void Remove(int variable);
  // For x_j = X_A d: moves along β_j += τ s, β_A −= τ s d, which changes no
  // fit, until a coefficient is zero, and puts j in its place.
  struct Exchanged {
    int left = -1;      // the variable that left, −1 where none shrinks
    double sign = 0.0;  // of its target
    bool entered = false;
  };
  Exchanged Exchange(int entering, double sign);

  int refined() const { return refined_; }        // solutions
  int refactored() const { return refactored_; }  // factors

 private:
  // c of β, as high + low.
  void SharpC(const double* beta, Eigen::VectorXd& high,
              Eigen::VectorXd& low) const;
  double SolveOnce(double lambda, double rounding);
  void Products();
  double ActiveViolation(double lambda) const;
  double InactiveViolation(double lambda) const;
  void Refine(double lambda);
  bool Refactor();
  void AppendUnpenalised();

  const LassoObjective& objective_;
  const Eigen::MatrixXd& gram_;
  std::vector<State> states_;
  std::vector<int> columns_;
  int num_unpenalised_ = 0;
  UpdatableCholesky cholesky_;
  Eigen::VectorXd target_;  // these four by position, the first size()
  Eigen::VectorXd half_;    // of the slope: U⁻ᵀ target
  Eigen::VectorXd beta_;
  Eigen::VectorXd slope_;
  Eigen::VectorXd c_;
  Eigen::VectorXd b_;
  Eigen::VectorXd inverse_weights_;
  Eigen::VectorXd root_diagonal_;  // √G_jj
  double weighted_root_ = 0.0;     // max_j √G_jj / w_j
  double greatest_inverse_ = 0.0;  // max_j 1 / w_j
  double scale_ = 0.0;
  Eigen::VectorXd work_;
  int refined_ = 0;
  int refactored_ = 0;
};

}  // namespace mle

#endif  // MLE_REGRESSION_ACTIVE_SET_H_
