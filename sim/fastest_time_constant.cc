#include "sim/fastest_time_constant.h"

#include "Eigen/Eigenvalues"

namespace mle::sim {

double FastestTimeConstant(const Eigen::MatrixXd& A) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(
      A, /*computeEigenvectors=*/false);
  return 1.0 / solver.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace mle::sim
