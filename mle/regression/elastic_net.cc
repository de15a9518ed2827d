#include "mle/regression/elastic_net.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "Eigen/Cholesky"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/regression/duality_gap.h"

namespace mle {
namespace {

// Lasso on a strictly convex quadratic, from a start near the minimiser.
class FeatureSignSearch {
 public:
  FeatureSignSearch(const LassoObjective& objective, double lambda)
      : objective_(objective), gram_(*objective.gram), lambda_(lambda) {}

  // Returns whether the search ended at the minimiser.
  bool Run(int max_steps, Eigen::VectorXd& beta) {
    sign_ = beta.cwiseSign();
    for (int step = 0; step < max_steps; ++step) {
      const bool settled = StepTowardsMinimiser(beta);
      if (!settled) continue;
      if (!Activate(beta)) return true;
    }
    return false;
  }

 private:
  double Objective(const Eigen::VectorXd& beta,
                   const std::vector<int>& active) const {
    double value = 0.0;
    for (const int i : active) {
      double product = 0.0;
      for (const int j : active) product += gram_(j, i) * beta(j);
      value += beta(i) * (0.5 * product - objective_.correlation(i)) +
               lambda_ * objective_.weights(i) * std::abs(beta(i));
    }
    return value;
  }

  // Goes to the minimiser for the present signs, or to the best point on the
  // way where a coefficient becomes zero. True if no sign changed.
  bool StepTowardsMinimiser(Eigen::VectorXd& beta) {
    std::vector<int> active;
    for (int j = 0; j < beta.size(); ++j) {
      if (sign_(j) != 0.0 ||
          (objective_.weights(j) == 0.0 && gram_(j, j) > 0.0)) {
        active.push_back(j);
      }
    }
    if (active.empty()) return true;
    const Eigen::VectorXd target =
        objective_.correlation(active) -
        lambda_ * objective_.weights(active).cwiseProduct(sign_(active));
    const Eigen::VectorXd goal =
        Eigen::LLT<Eigen::MatrixXd>(gram_(active, active)).solve(target);
    const Eigen::VectorXd start = beta(active);
    const Eigen::VectorXd signs = sign_(active);
    // On the way to the goal each coefficient that changes its sign passes
    // zero.
    Eigen::VectorXd best = beta;
    double smallest = std::numeric_limits<double>::infinity();
    bool crosses = false;
    const auto consider = [&](double t, Eigen::Index zero) {
      Eigen::VectorXd candidate = beta;
      candidate(active) = start + t * (goal - start);
      if (zero >= 0) candidate(active[zero]) = 0.0;
      const double value = Objective(candidate, active);
      if (value < smallest) {
        smallest = value;
        best = candidate;
      }
    };
    for (Eigen::Index i = 0; i < goal.size(); ++i) {
      if (signs(i) != 0.0 && goal(i) * signs(i) < 0.0) {
        crosses = true;
        consider(start(i) / (start(i) - goal(i)), i);
      }
    }
    if (!crosses) {
      beta(active) = goal;
      return true;
    }
    consider(1.0, -1);
    beta = best;
    sign_ = beta.cwiseSign();
    return false;
  }

  // Lets the coefficient that violates its bound most in. False if none does.
  bool Activate(const Eigen::VectorXd& beta) {
    Eigen::VectorXd c = objective_.correlation;
    for (int j = 0; j < beta.size(); ++j) {
      if (beta(j) != 0.0) c -= beta(j) * gram_.col(j);
    }
    int entering = -1;
    double worst = 1.0 + 1e-12;
    for (int j = 0; j < beta.size(); ++j) {
      const double w = objective_.weights(j);
      if (sign_(j) != 0.0 || w == 0.0 || !std::isfinite(w)) continue;
      const double ratio = std::abs(c(j)) / (lambda_ * w);
      if (ratio > worst) {
        worst = ratio;
        entering = j;
      }
    }
    if (entering < 0) return false;
    sign_(entering) = c(entering) > 0.0 ? 1.0 : -1.0;
    return true;
  }

  const LassoObjective& objective_;
  const Eigen::MatrixXd& gram_;
  double lambda_;
  Eigen::VectorXd sign_;  // 0 for coefficients held at zero
};

}  // namespace

absl::Status ElasticNetOptions::Validate() const {
  if (!(ratio > 0.0 && ratio <= 1.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "elastic net: ratio is %g; it must be above 0 and at most 1", ratio));
  }
  if (!(tolerance > 0.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "elastic net: tolerance is %g; it must be positive", tolerance));
  }
  if (max_steps < 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "elastic net: max_steps is %d; it must be at least 1", max_steps));
  }
  return absl::OkStatus();
}

absl::StatusOr<LassoSolution> SolveElasticNet(
    const LassoObjective& objective, const Eigen::VectorXd& lambdas,
    const ElasticNetOptions& options) {
  MLE_RETURN_IF_ERROR(objective.Validate());
  MLE_RETURN_IF_ERROR(options.Validate());
  if (lambdas.size() == 0) {
    return absl::InvalidArgumentError("elastic net: the grid of λ is empty");
  }
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    if (!(lambdas(i) > 0.0) || !std::isfinite(lambdas(i)) ||
        (i > 0 && !(lambdas(i) > lambdas(i - 1)))) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "elastic net: value %d of the grid of λ is %g; they must be positive "
          "and ascend",
          i + 1, lambdas(i)));
    }
  }
  Eigen::MatrixXd gram = *objective.gram;
  LassoObjective ridged = objective;
  ridged.gram = &gram;

  LassoSolution solution;
  solution.lambdas = lambdas;
  solution.relative_gap.setZero(lambdas.size());
  solution.path = LassoPath(objective.size());
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(objective.size());
  Eigen::VectorXd before = beta;
  int not_converged = 0;
  for (Eigen::Index i = lambdas.size() - 1; i >= 0; --i) {
    const double lambda = lambdas(i);
    for (int j = 0; j < objective.size(); ++j) {
      // Constant regressors stay without variation.
      const double square = (*objective.gram)(j, j);
      gram(j, j) = square > 0.0 ? square + lambda * (1.0 - options.ratio) : 0.0;
    }
    before = beta;
    FeatureSignSearch(ridged, lambda * options.ratio)
        .Run(options.max_steps, beta);
    solution.relative_gap(i) =
        ComputeDualityGap(ridged, lambda * options.ratio, beta).Relative();
    if (!(solution.relative_gap(i) <= options.tolerance)) ++not_converged;
    const double from =
        i + 1 < lambdas.size()
            ? lambdas(i + 1)
            : std::max(lambda, objective.LambdaMax() / options.ratio);
    solution.path.AppendJoin(from, before, lambda, beta);
  }
  solution.report = absl::StrFormat(
      "elastic net: %d values of λ, %d above the tolerance, relative gap ≤ "
      "%.2g",
      lambdas.size(), not_converged, solution.MaxRelativeGap());
  return solution;
}

}  // namespace mle
