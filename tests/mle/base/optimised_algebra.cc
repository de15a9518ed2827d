#include "tests/mle/base/optimised_algebra.h"

#include <complex>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "Eigen/SVD"

namespace mle {

Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues();
}

Eigen::MatrixXcd Solve(const Eigen::MatrixXcd& A, const Eigen::MatrixXcd& B) {
  return A.partialPivLu().solve(B);
}

Eigen::VectorXd SingularValues(const Eigen::MatrixXd& A) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues();
}

Eigen::VectorXcd FourierSums(const Eigen::MatrixXd& h, double omega) {
  Eigen::VectorXcd turns(h.rows());
  for (Eigen::Index l = 0; l < turns.size(); ++l) {
    turns(l) = std::polar(1.0, -omega * static_cast<double>(l));
  }
  return h.transpose() * turns;
}

}  // namespace mle
