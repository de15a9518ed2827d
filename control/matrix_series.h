// Power series with matrices as coefficients, and what they are on circles: the
// transfer matrices of sampled responses. Internal to control.

#ifndef CONTROL_MATRIX_SERIES_H_
#define CONTROL_MATRIX_SERIES_H_

#include <complex>

#include "Eigen/Core"

namespace mle::control {

// Σ_{a≥1} (C_a + R) w^a = Σ_{a=1}^{n} C_a w^a + R w/(1 − w) with real matrices
// C_a and R: what a series that ends in R differs from it by.
class MatrixSeries {
 public:
  // Of n matrices like `end`, R, all of them 0 but for it.
  MatrixSeries(const Eigen::MatrixXd& end, Eigen::Index degree);

  Eigen::Index degree() const { return coefficients_.rows(); }
  Eigen::Index entries() const { return coefficients_.cols(); }
  // C_a + R.
  void SetTerm(Eigen::Index a, const Eigen::MatrixXd& value);
  // Cuts off the negligible end.
  void Trim();

  // At w, of which the powers are given.
  Eigen::MatrixXcd operator()(const Eigen::VectorXcd& powers) const;
  // At each w of which a column has the powers, column by column of each
  // matrix.
  Eigen::MatrixXcd AtAll(
      const Eigen::Ref<const Eigen::MatrixXcd>& powers) const;
  // At r e^{iπk/n}, k = 0 … n, column by column of each matrix: roots of unity
  // but for r, so that a transform of 2n numbers does for any degree.
  Eigen::MatrixXcd OnHalfCircle(double radius, int n) const;
  // A matrix of column k of those.
  Eigen::MatrixXcd Column(const Eigen::MatrixXcd& values, Eigen::Index k) const;

  // Σ_i K_i (C_{a+i} + R) of blocks K_i that stand side by side in `gain`. Each
  // entry is a sum of correlations, which are products of Fourier transforms:
  // for h blocks of m × p and matrices C of p × m that takes O((n + h) p m²)
  // operations, the sums themselves O(n h p m²).
  MatrixSeries Ahead(const Eigen::MatrixXd& gain) const;

 private:
  Eigen::Index rows_;
  Eigen::VectorXd end_;  // the entries of R
  bool ends_in_zero_;
  Eigen::MatrixXd coefficients_;  // those of C_a in row a − 1
};

}  // namespace mle::control

#endif  // CONTROL_MATRIX_SERIES_H_
