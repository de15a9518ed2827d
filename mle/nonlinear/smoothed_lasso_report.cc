#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/nonlinear/smoothed_lasso.h"

namespace mle {

using Eigen::VectorXd;

absl::Status SmoothedLassoOptions::Validate() const {
  const auto fault = [](const char* field, auto value, const char* constraint) {
    return absl::InvalidArgumentError(absl::StrCat(
        "smoothed lasso: ", field, " is ", value, ", must be ", constraint));
  };
  if (!(tolerance > 0.0) || !std::isfinite(tolerance)) {
    return fault("tolerance", tolerance, "finite and positive");
  }
  if (!(smoothing_decrease > 0.0 && smoothing_decrease < 1.0)) {
    return fault("smoothing_decrease", smoothing_decrease, "between 0 and 1");
  }
  if (max_stages < 1) return fault("max_stages", max_stages, "at least 1");
  if (max_iterations < 1) {
    return fault("max_iterations", max_iterations, "at least 1");
  }
  return absl::OkStatus();
}

std::string SmoothedLassoSummary::BriefReport() const {
  const char* how = "not run";
  switch (termination) {
    case SmoothedLassoTermination::kNotRun:
      break;
    case SmoothedLassoTermination::kConverged:
      how = "converged";
      break;
    case SmoothedLassoTermination::kStageLimit:
      how = "not converged";
      break;
    case SmoothedLassoTermination::kFailed:
      how = "failed";
      break;
  }
  return absl::StrFormat(
      "smoothed lasso: %s, relative gap %.1e, smoothing %.1e, %d coefficients "
      "not zero, %d solves of at most %d unknowns, %d iterations (Ceres: %s)",
      how, gap.Relative(), smoothing, num_nonzero, solves, max_unknowns,
      iterations, message);
}

LassoSolverOptions SmoothedLassoSolver(const SmoothedLassoOptions& options) {
  LassoSolverOptions solver;
  solver.solver = LassoSolver::kFunction;
  solver.function = [options](
                        const LassoObjective& objective, double lambda,
                        const VectorXd& start) -> absl::StatusOr<VectorXd> {
    MLE_ASSIGN_OR_RETURN(SmoothedLassoSummary summary,
                         SolveSmoothedLasso(objective, lambda, start, options));
    if (summary.termination == SmoothedLassoTermination::kFailed) {
      return absl::InternalError(
          absl::StrCat("λ = ", lambda, ": ", summary.BriefReport()));
    }
    return std::move(summary.beta);
  };
  return solver;
}

}  // namespace mle
