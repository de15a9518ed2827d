#include "sim/fastest_time_constant.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Eigenvalues"

namespace mle::sim {

// The poles are those of the monic denominator with time scaled so that its
// largest coefficient is 1, which keeps the largest one accurate in any unit of
// time.
double FastestTimeConstant(const std::vector<double>& denominator) {
  const int r = static_cast<int>(denominator.size()) - 1;
  double scale = 0.0;
  for (int i = 1; i <= r; ++i) {
    const double a = std::abs(denominator[i] / denominator[0]);
    scale = std::max(scale, std::pow(a, 1.0 / i));
  }
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(r, r);
  companion.diagonal(-1).setOnes();
  for (int i = 1; i <= r; ++i) {
    companion(0, i - 1) = -denominator[i] / denominator[0] / std::pow(scale, i);
  }
  return FastestTimeConstant(companion) / scale;
}

double FastestTimeConstant(const Eigen::MatrixXd& A) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(
      A, /*computeEigenvectors=*/false);
  return 1.0 / solver.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace mle::sim
