// Decompositions of large matrices that tests compare with, in a library that
// is optimised, as tests are not.

#ifndef TESTS_MLE_BASE_OPTIMISED_ALGEBRA_H_
#define TESTS_MLE_BASE_OPTIMISED_ALGEBRA_H_

#include "Eigen/Core"

namespace mle {

Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A);

// C (e^{jω} I − A)⁻¹ B + D.
Eigen::MatrixXcd FrequencyResponse(const Eigen::MatrixXd& A,
                                   const Eigen::MatrixXd& B,
                                   const Eigen::MatrixXd& C,
                                   const Eigen::MatrixXd& D, double omega);

// Descending.
Eigen::VectorXd SingularValues(const Eigen::MatrixXd& A);

// Σ_l h(l) e^{−jωl} of each column of h.
Eigen::VectorXcd FourierSums(const Eigen::MatrixXd& h, double omega);

}  // namespace mle

#endif  // TESTS_MLE_BASE_OPTIMISED_ALGEBRA_H_
