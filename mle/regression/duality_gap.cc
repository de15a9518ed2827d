#include "mle/regression/duality_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/Eigenvalues"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/regression/unpenalised.h"
#include "mle/regression/updatable_cholesky.h"

namespace mle {
namespace {

// Those that are not excluded.
std::vector<int> Free(const LassoObjective& objective) {
  std::vector<int> free;
  for (int j = 0; j < objective.size(); ++j) {
    if (std::isfinite(objective.weights(j))) free.push_back(j);
  }
  return free;
}

// G_FF⁺ c_F.
Eigen::VectorXd PseudoSolve(const Eigen::MatrixXd& gram,
                            const std::vector<int>& free,
                            const Eigen::VectorXd& gradient) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram(free, free));
  const double threshold = static_cast<double>(free.size()) *
                           std::numeric_limits<double>::epsilon() *
                           std::max(eigen.eigenvalues().maxCoeff(), 0.0);
  Eigen::VectorXd coordinates =
      eigen.eigenvectors().transpose() * gradient(free);
  coordinates =
      (eigen.eigenvalues().array() > threshold)
          .select(coordinates.array() / eigen.eigenvalues().array(), 0.0);
  return eigen.eigenvectors() * coordinates;
}

bool UsesExcluded(const LassoObjective& objective,
                  const Eigen::VectorXd& beta) {
  for (int j = 0; j < beta.size(); ++j) {
    if (beta(j) != 0.0 && !std::isfinite(objective.weights(j))) return true;
  }
  return false;
}

// The best step of the unpenalised coefficients: adds what it gains to
// `result`, and takes it off `gradient` and `residual_square`.
void StepUnpenalised(const LassoObjective& objective, Eigen::VectorXd& gradient,
                     double& residual_square, DualityGap& result) {
  UpdatableCholesky factor(/*capacity=*/1);
  const std::vector<int> free = IndependentUnpenalised(objective, factor);
  if (free.empty()) return;
  const Eigen::VectorXd own = gradient(free);
  result.kkt_violation = own.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd step = own;
  factor.SolveInPlace(step);
  const double explained = step.dot(own);
  residual_square = std::max(residual_square - explained, 0.0);
  result.gap += 0.5 * explained;
  for (std::size_t i = 0; i < free.size(); ++i) {
    gradient -=
        step(static_cast<Eigen::Index>(i)) * objective.gram->col(free[i]);
  }
}

// With the residual scaled by α ≤ 1, which makes it feasible for the dual
// whatever c_j is within its rounding.
void AddPenalised(const LassoObjective& objective, double lambda,
                  const Eigen::VectorXd& beta, const Eigen::VectorXd& gradient,
                  const Eigen::VectorXd& rounding, double residual_square,
                  DualityGap& result) {
  const auto rounding_of = [&](int j) {
    return rounding.size() == 0 ? 0.0 : rounding(j);
  };
  double ratio = 1.0;
  for (int j = 0; j < beta.size(); ++j) {
    const double w = objective.weights(j);
    if (w == 0.0 || !std::isfinite(w)) continue;
    ratio = std::max(ratio,
                     (std::abs(gradient(j)) + rounding_of(j)) / (lambda * w));
  }
  const double alpha = 1.0 / ratio;
  result.gap += 0.5 * (1.0 - alpha) * (1.0 - alpha) * residual_square;
  result.kkt_violation = std::max(result.kkt_violation, (ratio - 1.0) * lambda);
  for (int j = 0; j < beta.size(); ++j) {
    const double w = objective.weights(j);
    if (beta(j) == 0.0 || w == 0.0) continue;
    const double signed_gradient = std::copysign(1.0, beta(j)) * gradient(j);
    result.primal += lambda * w * std::abs(beta(j));
    result.gap += std::abs(beta(j)) *
                  (lambda * w - alpha * (signed_gradient - rounding_of(j)));
    result.kkt_violation = std::max(result.kkt_violation,
                                    std::abs(signed_gradient - lambda * w) / w);
  }
}

}  // namespace

double DualityGap::Relative() const {
  if (gap == 0.0 || !std::isfinite(gap)) return gap;
  return gap /
         std::max(primal - primal_rounding,
                  std::numeric_limits<double>::epsilon() * response_square);
}

void PrimalRounding::Add(int j, double beta) {
  product_ += std::abs(beta * objective_.correlation(j));
  const double square = std::max((*objective_.gram)(j, j), 0.0);
  length_ += std::sqrt(square) * std::abs(beta);
}

double PrimalRounding::Value() const {
  return std::numeric_limits<double>::epsilon() *
         (objective_.response_square + product_ + length_ * length_);
}

Eigen::VectorXd MinimumNormLeastSquares(const LassoObjective& objective) {
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(objective.size());
  const std::vector<int> free = Free(objective);
  beta(free) = PseudoSolve(*objective.gram, free, objective.correlation);
  return beta;
}

double LeastSquaresGap(const LassoObjective& objective,
                       const Eigen::VectorXd& gradient) {
  const std::vector<int> free = Free(objective);
  if (free.empty()) return 0.0;
  const Eigen::VectorXd step = PseudoSolve(*objective.gram, free, gradient);
  return std::max(0.5 * step.dot(gradient(free)), 0.0);
}

DualityGap ComputeDualityGap(const LassoObjective& objective, double lambda,
                             const Eigen::VectorXd& beta) {
  CHECK_EQ(beta.size(), objective.size());
  const DualityGap nothing_known = {kInfinity, kInfinity, kInfinity,
                                    objective.response_square, kInfinity};
  if (UsesExcluded(objective, beta)) return nothing_known;
  Eigen::VectorXd c = objective.correlation;
  PrimalRounding rounding(objective);
  for (int j = 0; j < beta.size(); ++j) {
    if (beta(j) == 0.0) continue;
    c -= beta(j) * objective.gram->col(j);
    rounding.Add(j, beta(j));
  }
  DualityGap result;
  result.response_square = objective.response_square;
  result.primal_rounding = rounding.Value();
  double residual_square = std::max(
      objective.response_square - beta.dot(objective.correlation + c), 0.0);
  result.primal = 0.5 * residual_square;
  if (lambda == 0.0) {
    result.gap = LeastSquaresGap(objective, c);
    for (const int j : Free(objective)) {
      result.kkt_violation = std::max(result.kkt_violation, std::abs(c(j)));
    }
    return std::isfinite(result.gap) ? result : nothing_known;
  }
  const DualityGap gap =
      GapOfGradient(objective, lambda, beta, std::move(c), residual_square);
  if (!std::isfinite(gap.gap)) return nothing_known;
  result.primal = gap.primal;
  result.gap = gap.gap;
  result.kkt_violation = gap.kkt_violation;
  return result;
}

DualityGap GapOfGradient(const LassoObjective& objective, double lambda,
                         const Eigen::VectorXd& beta, Eigen::VectorXd gradient,
                         double residual_square,
                         const Eigen::VectorXd& rounding) {
  DualityGap result;
  result.response_square = objective.response_square;
  result.primal = 0.5 * residual_square;
  StepUnpenalised(objective, gradient, residual_square, result);
  AddPenalised(objective, lambda, beta, gradient, rounding, residual_square,
               result);
  if (!std::isfinite(result.gap) || !std::isfinite(result.primal)) {
    result.gap = kInfinity;
  }
  result.gap = std::max(result.gap, 0.0);
  return result;
}

}  // namespace mle
