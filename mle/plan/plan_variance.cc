#include "mle/plan/plan_variance.h"

#include <cmath>

#include "Eigen/Eigenvalues"
#include "mle/base/double_limits.h"

namespace mle {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double VarianceOfSize::At(double size) const {
  return (squares.array() / (1.0 + size * size * growth.array())).sum();
}

double MeanAt(const Variances& variances, double size) {
  double sum = 0.0;
  for (const VarianceOfSize& variance : variances) sum += variance.At(size);
  return sum / static_cast<double>(variances.size());
}

double LeastSizeFor(const Variances& variances, double wanted) {
  if (MeanAt(variances, 0.0) <= wanted) return 0.0;
  if (MeanAt(variances, kLargestSize) > wanted) return kInfinity;
  double low = -30.0;
  double high = std::log(kLargestSize);
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (low + high);
    (MeanAt(variances, std::exp(middle)) > wanted ? low : high) = middle;
  }
  return std::exp(high);
}

VarianceOfSize VarianceOf(const MatrixXd& root, const MatrixXd& information,
                          Index place) {
  const auto lower = root.triangularView<Eigen::Lower>();
  const MatrixXd half = lower.solve(information);
  const MatrixXd relative = lower.solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(
      0.5 * (relative + relative.transpose()));
  const VectorXd own = lower.solve(VectorXd::Unit(root.rows(), place)).eval();
  const VectorXd along = solver.eigenvectors().transpose() * own;
  return {along.cwiseAbs2(), solver.eigenvalues().cwiseMax(0.0)};
}

}  // namespace mle
