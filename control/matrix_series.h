// Power series with matrices as coefficients, and what they are on circles: the
// transfer matrices of sampled responses. Internal to control.

#ifndef CONTROL_MATRIX_SERIES_H_
#define CONTROL_MATRIX_SERIES_H_

#include <vector>

#include "Eigen/Core"

namespace mle::control {

// Σ_{a=1}^{n} C_a w^a with real matrices C_a.
class MatrixSeries {
 public:
  // A series of n = `degree` matrices of rows × columns, all of them 0.
  MatrixSeries(Eigen::Index rows, Eigen::Index columns, Eigen::Index degree);

  Eigen::Index degree() const { return coefficients_.rows(); }
  // The number of a matrix's entries that are not zero in every term; all
  // entries before Trim().
  Eigen::Index entries() const { return coefficients_.cols(); }
  // C_a.
  void SetTerm(Eigen::Index a, const Eigen::MatrixXd& value);
  // Cuts off the negligible end and entries that are zero. No term can be set
  // then.
  void Trim();

  // At w, of which the powers are given.
  Eigen::MatrixXcd operator()(const Eigen::VectorXcd& powers) const;
  // The entries at each w of which a column has the powers.
  Eigen::MatrixXcd AtAll(
      const Eigen::Ref<const Eigen::MatrixXcd>& powers) const;
  // At r e^{iπk/n}, k = 0 … n: roots of unity but for r, so that a transform of
  // 2n numbers does for any degree.
  Eigen::MatrixXcd OnHalfCircle(double radius, int n) const;
  // The matrix of a column of those.
  Eigen::MatrixXcd Matrix(
      const Eigen::Ref<const Eigen::VectorXcd>& entries) const;

  // Σ_i K_i C_{a+i} of blocks K_i that stand side by side in `gain`. Each entry
  // is a sum of correlations, which are products of Fourier transforms: for h
  // blocks of m × p and matrices C of p × m with e entries that takes
  // O((n + h) e m) operations, the sums themselves O(n h e m).
  MatrixSeries Ahead(const Eigen::MatrixXd& gain) const;

 private:
  Eigen::Index rows_;
  Eigen::Index columns_;
  // Where in a matrix, column by column, the entries stand.
  std::vector<Eigen::Index> places_;
  Eigen::MatrixXd coefficients_;  // entries of C_a in row a − 1
};

}  // namespace mle::control

#endif  // CONTROL_MATRIX_SERIES_H_
