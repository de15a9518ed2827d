#include "mle/nonlinear/unit_errors.h"

#include <cmath>
#include <limits>

#include "Eigen/Eigenvalues"

namespace mle {
namespace {

// Eigenvalues of JᵀJ, its columns of length one, below the first count as zero,
// and so do parts of a direction below the second.
constexpr double kNoEffect = 1e-14;
constexpr double kNoPart = 1e-12;

}  // namespace

Eigen::VectorXd UnitErrors(const Eigen::MatrixXd& jacobian) {
  const Eigen::VectorXd norms =
      jacobian.colwise().norm().transpose().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = jacobian * norms.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      scaled.transpose() * scaled);
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(norms.size());
  for (Eigen::Index i = 0; i < norms.size(); ++i) {
    const bool has_effect = eigen.eigenvalues()(i) > kNoEffect;
    for (Eigen::Index j = 0; j < norms.size(); ++j) {
      const double part = std::pow(eigen.eigenvectors()(j, i), 2);
      if (has_effect) {
        variances(j) += part / eigen.eigenvalues()(i);
      } else if (part > kNoPart) {
        variances(j) = std::numeric_limits<double>::infinity();
      }
    }
  }
  return variances.cwiseSqrt().cwiseQuotient(norms);
}

}  // namespace mle
