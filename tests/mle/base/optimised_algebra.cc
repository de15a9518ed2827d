#include "tests/mle/base/optimised_algebra.h"

#include <complex>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "Eigen/SVD"

namespace mle {

Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues();
}

Eigen::MatrixXcd FrequencyResponse(const Eigen::MatrixXd& A,
                                   const Eigen::MatrixXd& B,
                                   const Eigen::MatrixXd& C,
                                   const Eigen::MatrixXd& D, double omega) {
  Eigen::MatrixXcd inner = -A.cast<std::complex<double>>();
  inner.diagonal().array() += std::polar(1.0, omega);
  const Eigen::MatrixXcd inputs = B.cast<std::complex<double>>();
  return C.cast<std::complex<double>>() * inner.partialPivLu().solve(inputs) +
         D.cast<std::complex<double>>();
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
