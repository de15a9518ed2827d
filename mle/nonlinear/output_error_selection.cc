#include "mle/nonlinear/output_error_selection.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "glog/logging.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMaxSweeps = 10'000;
constexpr double kSelectionTolerance = 1e-9;

// The minimiser of ½ zᵀHz − bᵀz + weight ‖z‖ over one group, by its norm: with
// H = VΛVᵀ, z = V (Λ + (weight/‖z‖) I)⁻¹ Vᵀb.
Vector3d MinimiseGroup(const Matrix3d& H, const Vector3d& b, double weight) {
  if (b.norm() <= weight) return Vector3d::Zero();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(H);
  const Vector3d rotated = eigen.eigenvectors().transpose() * b;
  const auto at = [&](double norm) -> Vector3d {
    return rotated.array() / (eigen.eigenvalues().array() + weight / norm);
  };
  // ‖at(norm)‖ − norm falls through zero once.
  double low = 0.0;
  double high = b.norm() / eigen.eigenvalues()(0);
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (at(middle).norm() > middle ? low : high) = middle;
  }
  return eigen.eigenvectors() * at(0.5 * (low + high));
}

}  // namespace

ElementSelection SelectChanged(const VectorXd& changes,
                               const MatrixXd& covariance,
                               const std::vector<double>& degrees_of_freedom,
                               double false_alarm) {
  const int groups = static_cast<int>(degrees_of_freedom.size());
  CHECK_EQ(changes.size(), 3 * groups);
  ElementSelection selection;
  if (groups == 0) return selection;
  // In the coordinates z = S δ the covariance's diagonal blocks are unit.
  MatrixXd to_unit = MatrixXd::Zero(3 * groups, 3 * groups);
  for (int g = 0; g < groups; ++g) {
    const Eigen::LLT<Matrix3d> factor(
        Matrix3d(covariance.block<3, 3>(3 * g, 3 * g)));
    to_unit.block<3, 3>(3 * g, 3 * g) =
        factor.matrixL().solve(Matrix3d::Identity());
  }
  const VectorXd target = to_unit * changes;
  const MatrixXd unit = to_unit * covariance * to_unit.transpose();
  const MatrixXd H =
      unit.ldlt().solve(MatrixXd::Identity(3 * groups, 3 * groups));

  std::vector<double> weights(groups);
  for (int g = 0; g < groups; ++g) {
    const double statistic = target.segment<3>(3 * g).squaredNorm();
    const double critical =
        3.0 * FisherQuantile(false_alarm, 3.0, degrees_of_freedom[g]);
    selection.statistics.push_back(statistic);
    selection.p_values.push_back(
        FisherTail(statistic / 3.0, 3.0, degrees_of_freedom[g]));
    weights[g] = critical / std::max(std::sqrt(statistic), 1e-300);
  }
  const VectorXd b = H * target;
  VectorXd z = target;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double moved = 0.0;
    for (int g = 0; g < groups; ++g) {
      const Matrix3d own = H.block<3, 3>(3 * g, 3 * g);
      const Vector3d former = z.segment<3>(3 * g);
      const Vector3d pull =
          b.segment<3>(3 * g) - H.middleRows<3>(3 * g) * z + own * former;
      z.segment<3>(3 * g) = MinimiseGroup(own, pull, weights[g]);
      moved = std::max(moved, (z.segment<3>(3 * g) - former).norm());
    }
    if (moved < kSelectionTolerance * (1.0 + target.norm())) break;
  }
  for (int g = 0; g < groups; ++g) {
    selection.changed.push_back(!z.segment<3>(3 * g).isZero(0.0) &&
                                selection.p_values[g] < false_alarm);
  }
  return selection;
}

}  // namespace mle
