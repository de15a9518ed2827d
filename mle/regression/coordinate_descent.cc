#include "mle/regression/coordinate_descent.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// The gap is asked for after this many sweeps, then at doubling intervals.
constexpr int kFirstCheck = 8;

class CoordinateDescent {
 public:
  CoordinateDescent(const LassoObjective& objective, double lambda,
                    const Eigen::VectorXd& start)
      : objective_(objective),
        gram_(*objective.gram),
        lambda_(lambda),
        beta_(start.size() > 0
                  ? start
                  : Eigen::VectorXd::Zero(objective.size()).eval()) {
    for (int j = 0; j < objective.size(); ++j) {
      if (!CanMove(j)) beta_(j) = 0.0;
    }
    RecomputeGradient();
  }

  const Eigen::VectorXd& beta() const { return beta_; }

  // ‖change of β‖₂ of one sweep over all coefficients, or over those ≠ 0.
  double Sweep(bool only_nonzero) {
    double change = 0.0;
    for (int j = 0; j < objective_.size(); ++j) {
      if (only_nonzero && beta_(j) == 0.0) continue;
      const double delta = Step(j);
      change += delta * delta;
    }
    return std::sqrt(change);
  }

  void RecomputeGradient() {
    c_ = objective_.correlation;
    for (int j = 0; j < objective_.size(); ++j) {
      if (beta_(j) != 0.0) c_ -= beta_(j) * gram_.col(j);
    }
  }

 private:
  // Neither excluded nor without any effect.
  bool CanMove(int j) const {
    return std::isfinite(objective_.weights(j)) && gram_(j, j) > 0.0;
  }

  double Step(int j) {
    if (!CanMove(j)) return 0.0;
    const double w = objective_.weights(j);
    const double square = gram_(j, j);
    const double target = c_(j) + square * beta_(j);
    const double shrunk = std::max(std::abs(target) - lambda_ * w, 0.0);
    const double delta = std::copysign(shrunk, target) / square - beta_(j);
    if (delta != 0.0) {
      beta_(j) += delta;
      c_ -= delta * gram_.col(j);
    }
    return delta;
  }

  const LassoObjective& objective_;
  const Eigen::MatrixXd& gram_;
  double lambda_;
  Eigen::VectorXd beta_;
  Eigen::VectorXd c_;
};

}  // namespace

absl::Status CoordinateDescentOptions::Validate() const {
  if (!(tolerance > 0.0) || !std::isfinite(tolerance)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tolerance is %g; it must be positive", tolerance));
  }
  if (max_sweeps < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("max_sweeps is %d; it must be ≥ 1", max_sweeps));
  }
  return absl::OkStatus();
}

absl::StatusOr<CoordinateDescentSummary> SolveCoordinateDescent(
    const LassoObjective& objective, double lambda,
    const Eigen::VectorXd& start, const CoordinateDescentOptions& options) {
  MLE_RETURN_IF_ERROR(objective.Validate());
  MLE_RETURN_IF_ERROR(options.Validate());
  if (!(lambda >= 0.0) || !std::isfinite(lambda)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("lasso: λ is %g; it must be ≥ 0", lambda));
  }
  if (start.size() != 0 && start.size() != objective.size()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("lasso: the start has %d entries, the problem %d",
                        start.size(), objective.size()));
  }
  if (!start.allFinite()) {
    return absl::InvalidArgumentError("lasso: the start is not finite");
  }
  using Stop = CoordinateDescentOptions::Stop;
  CoordinateDescent solver(objective, lambda, start);
  CoordinateDescentSummary summary;
  int next_check = kFirstCheck;
  bool only_nonzero = false;
  bool ran_away = false;
  while (summary.sweeps < options.max_sweeps) {
    const double change = solver.Sweep(only_nonzero);
    const double size = solver.beta().norm();
    ++summary.sweeps;
    ran_away = !std::isfinite(change);
    if (ran_away) break;
    if (options.stop == Stop::kRelativeChange) {
      summary.converged = change <= options.tolerance * size;
      if (summary.converged) break;
      continue;
    }
    if (summary.sweeps >= next_check || change == 0.0) {
      next_check = 2 * summary.sweeps;
      solver.RecomputeGradient();
      const double gap =
          ComputeDualityGap(objective, lambda, solver.beta()).Relative();
      if (gap <= options.tolerance || (change == 0.0 && !only_nonzero)) break;
    }
    // All coefficients again once those ≠ 0 have settled.
    only_nonzero = change > 1e-12 * size && summary.sweeps % 8 != 0;
  }
  summary.beta = ran_away ? CoordinateDescent(objective, lambda, start).beta()
                          : solver.beta();
  summary.gap = ComputeDualityGap(objective, lambda, summary.beta);
  if (options.stop == Stop::kDualityGap) {
    summary.converged = summary.gap.Relative() <= options.tolerance;
  }
  return summary;
}

}  // namespace mle
