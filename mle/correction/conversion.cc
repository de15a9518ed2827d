#include "mle/correction/conversion.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/correction/regression_data.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

absl::Status ConversionOptions::Validate() const {
  if (order < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("order is %d; it must be at least 1", order));
  }
  if (!(penalty >= 0.0) || !std::isfinite(penalty)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("conversion penalty is %g; it must be ≥ 0", penalty));
  }
  return absl::OkStatus();
}

absl::StatusOr<ConversionSummary> ConvertToArx(
    const Record& excitation, const ConversionOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(excitation.Validate());
  ConversionSummary summary;
  ArxModel& model = summary.model;
  model.sample_time = excitation.sample_time;
  model.order = options.order;
  model.num_outputs = excitation.num_outputs();
  model.num_inputs = excitation.num_inputs();
  model.R.setZero(model.num_outputs, model.num_regressors());

  // Against R = 0 the mismatch is the output itself.
  MLE_ASSIGN_OR_RETURN(
      const RegressionData data,
      RegressionData::Create({excitation}, model, options.scaling));
  const LassoProblem problem =
      MakeLassoProblem(ComputeLaggedMoments(data.window(0)), options.scaling);
  const Eigen::VectorXd lambda = Eigen::VectorXd::Constant(1, options.penalty);
  summary.residual_variance.setZero(model.num_outputs);
  for (int i = 0; i < model.num_outputs; ++i) {
    const LassoObjective objective(problem, i);
    MLE_ASSIGN_OR_RETURN(const LassoSolution solution,
                         SolveLasso(objective, lambda, options.solver));
    summary.max_relative_gap =
        std::max(summary.max_relative_gap, solution.MaxRelativeGap());
    const Eigen::VectorXd beta = solution.path.Coefficients(options.penalty);
    model.R.row(i) = problem.Unscale(beta).transpose();
    // A difference, whose rounding may be negative where the fit is exact.
    summary.residual_variance(i) = std::max(
        objective.response_square -
            beta.dot(2.0 * objective.correlation - problem.gram * beta),
        0.0);
  }
  return summary;
}

}  // namespace mle
