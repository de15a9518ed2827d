// A small dense, strictly convex quadratic program, solved repeatedly with new
// data, without allocating:
//
//   min_{x,s} ½ (x − x₀)ᵀ H (x − x₀) + ½ Σ_i c_i s_i²
//   subject to l_i − s_i ≤ a_iᵀ x ≤ h_i + s_i, i = 1 … r,
//
// where s_i = 0 for hard rows (c_i = ∞) and H: n × n is positive definite. x₀
// is the unconstrained minimiser, the solution where it meets all limits.
//
// The dual active-set method of Goldfarb and Idnani (Mathematical Programming
// 27, 1983, 1–33), which starts from x₀ and adds the most violated row until
// none is left, on the Gram matrix of the rows in use,
//
//   G = A_W H⁻¹ A_Wᵀ + diag(1/c_W) = L Lᵀ,   x = x₀ − H⁻¹ A_Wᵀ λ,
//
// in which a soft row costs no variable of its own (as in Arnström, Bemporad
// and Axehill, IEEE Transactions on Automatic Control 67, 2022, 4362–4369). The
// rows in use are kept for the next solution: a warm start.
//
//   MLE_ASSIGN_OR_RETURN(QuadraticProgram program,
//                        QuadraticProgram::Create(H, A, c));
//   program.Solve(x0, lower, upper);
//   program.x();

#ifndef CONTROL_QUADRATIC_PROGRAM_H_
#define CONTROL_QUADRATIC_PROGRAM_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"

namespace mle::control {

class QuadraticProgram {
 public:
  struct Summary {
    // Every limit holds to rounding and the multipliers have the right signs.
    // Otherwise x is not to be used: the limits contradict each other, or the
    // iterations did not suffice.
    bool converged = false;
    int iterations = 0;  // rows added or dropped
    int active_rows = 0;
  };

  // H: n × n, A: r × n, slack_cost: r, each > 0 or infinite. InvalidArgument if
  // shapes differ, or H is not positive definite.
  static absl::StatusOr<QuadraticProgram> Create(
      const Eigen::MatrixXd& H, const Eigen::MatrixXd& A,
      const Eigen::VectorXd& slack_cost);

  // lower ≤ upper (r), infinite where there is no limit.
  Summary Solve(const Eigen::Ref<const Eigen::VectorXd>& x0,
                const Eigen::Ref<const Eigen::VectorXd>& lower,
                const Eigen::Ref<const Eigen::VectorXd>& upper);

  const Eigen::VectorXd& x() const { return x_; }
  // λ (r): positive at an upper limit, negative at a lower one; H (x − x₀) =
  // −Aᵀλ, s_i = |λ_i| / c_i.
  const Eigen::VectorXd& multipliers() const { return multipliers_; }
  int num_rows() const { return static_cast<int>(A_.rows()); }

  // Forgets the rows in use: the next solution starts cold.
  void ForgetActiveRows();

 private:
  using RowMatrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  QuadraticProgram() = default;

  // The limit that is violated most, in units of the distance ‖·‖_H from it.
  struct Violation {
    int row = -1;  // none
    int side = 0;  // +1 the upper limit, −1 the lower one
    double amount = 0.0;
  };

  double Bound(int position) const;  // of a row in use
  void StartFromActiveRows();
  bool AddRow(Violation violation, Summary& summary);
  Violation FindViolation() const;
  void UpdateDirection();
  void SolveForMultipliers();
  void SolveWithFactor(Eigen::Ref<Eigen::VectorXd> v) const;
  void GramColumn(int row);
  bool AppendToFactor(int row, int side);
  void RemoveFromFactor(int position);

  RowMatrix A_;               // r × n
  Eigen::MatrixXd factor_;    // R of H = RᵀR
  RowMatrix scaled_rows_;     // A R⁻¹
  Eigen::VectorXd softness_;  // 1/c
  Eigen::VectorXd diagonal_;  // of the Gram matrix of all rows

  Eigen::VectorXd lower_, upper_;
  Eigen::VectorXd free_values_;  // A x₀
  Eigen::VectorXd values_;       // A x
  Eigen::VectorXd direction_;    // R (x − x₀)
  Eigen::VectorXd x_;
  Eigen::VectorXd multipliers_;

  // The rows in use: count_ of them, in the order of the factor L.
  int count_ = 0;
  std::vector<int> rows_;
  std::vector<int> sides_;
  std::vector<char> in_use_;
  RowMatrix L_;
  Eigen::VectorXd lambda_;
  Eigen::VectorXd column_;  // of G, for a row to be added
  Eigen::VectorXd step_;
  Eigen::VectorXd cosines_, sines_;  // of the rotations
};

}  // namespace mle::control

#endif  // CONTROL_QUADRATIC_PROGRAM_H_
