// Cholesky factor of the Gram matrix of a changing set of columns.
//
// G_AA = UᵀU with U upper triangular, its columns stored one after the other.
// Appending a column costs one triangular solve (k²), removing one costs Givens
// rotations (at most 3k²); neither touches the data. (Golub and Van Loan,
// Matrix Computations, 4th ed., 6.5.) A right-hand side t that changes with the
// set is carried along as z = U⁻ᵀt, so that G_AA⁻¹t = U⁻¹z takes one triangular
// solve in place of two.

#ifndef MLE_REGRESSION_UPDATABLE_CHOLESKY_H_
#define MLE_REGRESSION_UPDATABLE_CHOLESKY_H_

#include "Eigen/Core"

namespace mle {

class UpdatableCholesky {
 public:
  // Room for `capacity` columns to begin with; grows when needed.
  explicit UpdatableCholesky(int capacity);

  int size() const { return size_; }

  // Appends the column with inner products `cross` (k) with the present ones
  // and `square` with itself. Returns its pivot, square − ‖U⁻ᵀcross‖², the
  // squared distance from the others' span; where that is at most tolerance ×
  // square (dependent), nothing changes.
  double Append(const Eigen::Ref<const Eigen::VectorXd>& cross, double square,
                double tolerance);

  // Removes column `position`, and its entry out of z (as long as there are
  // columns); those behind it move up.
  void Remove(int position, Eigen::Ref<Eigen::VectorXd> z);

  // z ← U⁻ᵀz.
  void HalfSolveInPlace(Eigen::Ref<Eigen::VectorXd> z) const;
  // The last entry of z, whose others precede it, for the entry `target` of t.
  double LastOfHalf(const Eigen::Ref<const Eigen::VectorXd>& z,
                    double target) const;
  // x ← U⁻¹x.
  void FinishInPlace(Eigen::Ref<Eigen::VectorXd> x) const;

  void Clear() { size_ = 0; }

  // x ← G_AA⁻¹ x, for the first columns alone where x is shorter.
  void SolveInPlace(Eigen::Ref<Eigen::VectorXd> x) const;

  // ‖U⁻ᵀx‖² = xᵀ G_AA⁻¹ x.
  double InverseQuadraticForm(const Eigen::VectorXd& x) const;

  // (min diagonal of U / max diagonal)²: an upper bound of 1/cond(G_AA).
  double ReciprocalConditionBound() const;

 private:
  Eigen::MatrixXd factor_;
  int size_ = 0;
};

}  // namespace mle

#endif  // MLE_REGRESSION_UPDATABLE_CHOLESKY_H_
