#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "ceres/ceres.h"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"
#include "mle/nonlinear/fopdt_grid.h"
#include "mle/nonlinear/low_order_fit.h"
#include "mle/nonlinear/unit_errors.h"

namespace mle {
namespace {

using Response = Eigen::Ref<const Eigen::VectorXd>;

// Residuals h_k − y_k and, where wanted, their derivatives by K, ln T and L;
// time in samples. `columns` holds three arrays as long as the response, or
// nullptr.
void Evaluate(const Response& response, const FopdtParameters& parameters,
              double* residuals, const std::array<double*, 3>& columns) {
  const double rate = 1.0 / parameters.time_constant;
  const double ratio = std::exp(-rate);
  const double rise_per_sample = -std::expm1(-rate);
  // e^{−(k−L)/T} and one less it, by recursions that do not cancel.
  double decay = 0.0;
  double rise = 0.0;
  for (Eigen::Index k = 0; k < response.size(); ++k) {
    const double after = static_cast<double>(k) - parameters.delay;
    if (after > 1.0) {
      decay *= ratio;
      rise = rise_per_sample + ratio * rise;
    } else if (after > 0.0) {
      decay = std::exp(-after * rate);
      rise = -std::expm1(-after * rate);
    }
    const double slope = parameters.gain * decay * rate;
    residuals[k] = parameters.gain * rise - response(k);
    if (columns[0] != nullptr) columns[0][k] = rise;
    if (columns[1] != nullptr) columns[1][k] = -slope * after;
    if (columns[2] != nullptr) columns[2][k] = -slope;
  }
}

class FopdtCost : public ceres::CostFunction {
 public:
  explicit FopdtCost(const Response& response) : response_(response) {
    set_num_residuals(static_cast<int>(response.size()));
    *mutable_parameter_block_sizes() = {1, 1, 1};
  }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    std::array<double*, 3> columns = {nullptr, nullptr, nullptr};
    if (jacobians != nullptr) std::copy_n(jacobians, 3, columns.begin());
    mle::Evaluate(response_, {x[0][0], std::exp(x[1][0]), x[2][0]}, residuals,
                  columns);
    return true;
  }

 private:
  Response response_;
};

struct RefinedFopdt {
  FopdtParameters parameters;
  double cost = kInfinity;
  FopdtTermination termination = FopdtTermination::kFailed;
  int iterations = 0;
};

FopdtTermination FromCeres(ceres::TerminationType type) {
  switch (type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
      return FopdtTermination::kConverged;
    case ceres::NO_CONVERGENCE:
      return FopdtTermination::kIterationLimit;
    default:
      return FopdtTermination::kFailed;
  }
}

// Levenberg–Marquardt from `start`, with L in [min_delay, max_delay].
RefinedFopdt RefineFopdt(const Response& response, const FopdtParameters& start,
                         const FopdtBounds& bounds, double min_delay,
                         double max_delay, int max_iterations) {
  const double min_log = std::log(bounds.min_time_constant);
  const double max_log = std::log(bounds.max_time_constant);
  double gain = start.gain;
  double log_time = std::clamp(std::log(start.time_constant), min_log, max_log);
  double delay = std::clamp(start.delay, min_delay, max_delay);

  ceres::Problem problem;
  problem.AddResidualBlock(new FopdtCost(response), nullptr, &gain, &log_time,
                           &delay);
  const auto bound = [&problem](double* value, double low, double high) {
    if (low < high) {
      problem.SetParameterLowerBound(value, 0, low);
      problem.SetParameterUpperBound(value, 0, high);
    } else {
      problem.SetParameterBlockConstant(value);
    }
  };
  bound(&log_time, min_log, max_log);
  bound(&delay, min_delay, max_delay);

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-16;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  RefinedFopdt refined;
  refined.termination = FromCeres(summary.termination_type);
  refined.iterations = static_cast<int>(summary.iterations.size());
  if (summary.IsSolutionUsable()) {
    refined.parameters = {gain, std::exp(log_time), delay};
    refined.cost = summary.final_cost;
  }
  return refined;
}

// The search leaves only the polish. Within a sample the objective is smooth;
// a minimum may also lie in the kink at one of its ends.
RefinedFopdt RefineBest(const Response& response, const FopdtBounds& bounds,
                        const FopdtOptions& options) {
  const FopdtParameters start =
      FindFopdtStart(response, bounds, options.num_starts);
  const double low = std::floor(start.delay);
  const double high = std::min(low + 1.0, bounds.max_delay);
  const std::pair<double, double> ranges[] = {
      {low, high}, {low, low}, {high, high}};
  RefinedFopdt best;
  best.parameters = start;
  int iterations = 0;
  for (const auto& [min_delay, max_delay] : ranges) {
    const RefinedFopdt refined = RefineFopdt(response, start, bounds, min_delay,
                                             max_delay, options.max_iterations);
    iterations += refined.iterations;
    if (refined.cost < best.cost) best = refined;
  }
  best.iterations = iterations;
  return best;
}

bool IsPoor(const FopdtFit& fit, const FopdtOptions& options,
            double max_time_constant) {
  return fit.termination == FopdtTermination::kFailed ||
         fit.relative_rms > options.poor_relative_rms ||
         fit.relative_max_residual > options.poor_relative_residual ||
         fit.time_constant > 0.9 * max_time_constant ||
         !(fit.gain_standard_error < std::abs(fit.gain));
}

// The fit in the units of the response, `scale`, and of time.
FopdtFit MakeFit(const Response& response, const RefinedFopdt& refined,
                 double scale, double sample_time) {
  const Eigen::Index n = response.size();
  Eigen::VectorXd residuals(n);
  Eigen::MatrixXd jacobian(n, 3);
  Evaluate(
      response, refined.parameters, residuals.data(),
      {jacobian.col(0).data(), jacobian.col(1).data(), jacobian.col(2).data()});
  // The first sample is 0 in any model and says nothing.
  const double degrees_of_freedom = static_cast<double>(n - 1 - 3);
  const double deviation =
      std::sqrt(residuals.squaredNorm() / degrees_of_freedom);
  const Eigen::Vector3d unit_errors = UnitErrors(jacobian);
  const auto error = [&](int parameter, double unit) {
    return std::isinf(unit_errors(parameter))
               ? kInfinity
               : unit * deviation * unit_errors(parameter);
  };

  FopdtFit fit;
  fit.gain = scale * refined.parameters.gain;
  fit.time_constant = sample_time * refined.parameters.time_constant;
  fit.delay = sample_time * refined.parameters.delay;
  fit.gain_standard_error = error(0, scale);
  fit.time_constant_standard_error = error(1, fit.time_constant);
  fit.delay_standard_error = error(2, sample_time);
  // Rest, 0, belongs to every response, so that the range is never 0.
  const double range =
      std::max(response.maxCoeff(), 0.0) - std::min(response.minCoeff(), 0.0);
  fit.relative_rms =
      std::sqrt(residuals.squaredNorm() / static_cast<double>(n)) / range;
  fit.relative_max_residual = residuals.cwiseAbs().maxCoeff() / range;
  fit.termination = refined.termination;
  fit.iterations = refined.iterations;
  return fit;
}

absl::Status CheckResponse(const Response& response, double sample_time) {
  MLE_RETURN_IF_ERROR(
      ValidateSampleTime("FOPDT fit: sample_time", sample_time));
  if (response.size() < 5) {
    return absl::InvalidArgumentError(
        absl::StrCat("FOPDT fit: the step response has ", response.size(),
                     " samples, must have at least 5"));
  }
  for (Eigen::Index k = 0; k < response.size(); ++k) {
    if (!std::isfinite(response(k))) {
      return absl::InvalidArgumentError(
          absl::StrCat("FOPDT fit: sample ", k, " of the step response is ",
                       response(k), ", must be finite"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status FopdtOptions::Validate() const {
  const auto fault = [](const char* field, double value, const char* bound) {
    return absl::InvalidArgumentError(absl::StrCat(
        "FopdtOptions: ", field, " is ", value, ", must be ", bound));
  };
  if (!(max_delay >= 0.0)) {
    return fault("max_delay", max_delay, "at least 0");
  }
  if (!(min_time_constant_samples > 0.0 && min_time_constant_samples <= 1.0)) {
    return fault("min_time_constant_samples", min_time_constant_samples,
                 "in (0, 1]");
  }
  if (!(max_time_constant_horizons >= 1.0 &&
        max_time_constant_horizons <= 1e6)) {
    return fault("max_time_constant_horizons", max_time_constant_horizons,
                 "in [1, 1e6]");
  }
  if (!(negligible_response >= 0.0)) {
    return fault("negligible_response", negligible_response, "at least 0");
  }
  if (!(poor_relative_rms > 0.0)) {
    return fault("poor_relative_rms", poor_relative_rms, "positive");
  }
  if (!(poor_relative_residual > 0.0)) {
    return fault("poor_relative_residual", poor_relative_residual, "positive");
  }
  if (num_starts < 1) return fault("num_starts", num_starts, "at least 1");
  if (max_iterations < 1) {
    return fault("max_iterations", max_iterations, "at least 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<FopdtFit> FitFopdt(const Response& step_response,
                                  double sample_time,
                                  const FopdtOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckResponse(step_response, sample_time));
  const double scale = step_response.cwiseAbs().maxCoeff();
  if (scale == 0.0 || scale <= options.negligible_response) {
    FopdtFit fit;
    fit.shape = FopdtShape::kNoResponse;
    fit.termination = FopdtTermination::kConverged;
    fit.gain_standard_error = 0.0;
    fit.relative_rms = 0.0;
    fit.relative_max_residual = 0.0;
    return fit;
  }
  const Eigen::VectorXd response = step_response / scale;
  const double last = static_cast<double>(response.size() - 1);
  const FopdtBounds bounds = {
      .min_time_constant = options.min_time_constant_samples,
      .max_time_constant = options.max_time_constant_horizons * last,
      .max_delay = std::min(options.max_delay / sample_time, last - 3.0)};
  const RefinedFopdt best = RefineBest(response, bounds, options);
  FopdtFit fit = MakeFit(response, best, scale, sample_time);
  fit.shape = IsPoor(fit, options, sample_time * bounds.max_time_constant)
                  ? FopdtShape::kPoorFit
                  : FopdtShape::kFits;
  return fit;
}

}  // namespace mle
