#include "apps/lifecycle/loop_flags.h"

#include <cmath>
#include <limits>
#include <string>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/loop_flags.h"
#include "apps/lifecycle/durations.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"
#include "mle/model/process_model.h"
#include "sim/check_options.h"

DEFINE_string(min_input, "",
              "Lower limits of the inputs: one value, or one for each input. "
              "Empty: minus four times the inputs that hold the outputs at any "
              "set points within --setpoint_range.");
DEFINE_string(max_input, "", "Upper limits of the inputs, as --min_input.");
DEFINE_string(
    min_output, "",
    "Lower limits of the outputs (soft limits of the controller): one value, "
    "or one for each output. Empty: -1.5 times --setpoint_range.");
DEFINE_string(max_output, "", "Upper limits of the outputs, as --min_output.");
DEFINE_string(output_limit_cost, "1000",
              "Weight of the squared violation of an output limit in the "
              "controller, > 0: one value, or one for each output.");

DEFINE_string(disturbance_deviation, "0.1",
              "Standard deviation of a slow disturbance of the outputs, ≥ 0: "
              "one value, or one for each output.");
DEFINE_string(disturbance_time, "1d",
              "Correlation time of that disturbance (s, min, h, d, w, y).");
DEFINE_double(window, 0.0,
              "Length of the record kept before and after a set-point change, "
              "in the model's time unit (min); 0: one and a half times the "
              "model's settling time.");
DEFINE_double(quiet_stretch, 0.0,
              "Simulated part of a quiet time, which represents all of it "
              "(min); 0: three times the model's settling time.");
DEFINE_double(warm_up, 0.0,
              "Simulated time before the quiet stretch, which does not count "
              "(min); 0: the model's settling time.");
DEFINE_bool(every_sample, false,
            "Simulates every sample of all years, with an ageing plant, "
            "instead of a stretch of each quiet time. Slow.");

namespace mle::lifecycle {
namespace {

using Eigen::VectorXd;

// How far beyond what is needed inputs and outputs may go.
constexpr double kInputMargin = 4.0;
constexpr double kOutputMargin = 1.5;

absl::Status Of(const char* flag, const absl::Status& status) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, ": ", status.message()));
}

// The numbers of a flag, or what stands for an empty one.
absl::StatusOr<VectorXd> NumbersOr(const char* flag, const std::string& value,
                                   const VectorXd& if_empty) {
  if (value.empty()) return if_empty;
  return ParseNumbers(flag, value, static_cast<int>(if_empty.size()));
}

// The largest input that holds the outputs anywhere within ± range: for each
// manipulated input the sum over the outputs of |K⁺| range.
VectorXd NeededInputs(const ProcessModel& model, const VectorXd& range) {
  Eigen::MatrixXd gains = StaticGains(model);
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.inputs()[j].role != InputRole::kManipulated) {
      gains.col(j).setZero();
    }
  }
  const Eigen::MatrixXd inverse =
      gains.completeOrthogonalDecomposition().pseudoInverse();
  return inverse.cwiseAbs() * range;
}

absl::Status SetController(const ProcessModel& model, const VectorXd& range,
                           OperationOptions& operation) {
  const int p = model.num_outputs();
  MLE_ASSIGN_OR_RETURN(operation.controller, ControllerFromFlags(model));
  control::MpcOptions& mpc = operation.controller;
  const VectorXd inputs = kInputMargin * NeededInputs(model, range);
  const VectorXd outputs = kOutputMargin * range;
  control::MpcLimits& limits = mpc.limits;
  MLE_ASSIGN_OR_RETURN(limits.min_input,
                       NumbersOr("min_input", FLAGS_min_input, -inputs));
  MLE_ASSIGN_OR_RETURN(limits.max_input,
                       NumbersOr("max_input", FLAGS_max_input, inputs));
  MLE_ASSIGN_OR_RETURN(limits.min_output,
                       NumbersOr("min_output", FLAGS_min_output, -outputs));
  MLE_ASSIGN_OR_RETURN(limits.max_output,
                       NumbersOr("max_output", FLAGS_max_output, outputs));
  MLE_ASSIGN_OR_RETURN(
      limits.output_limit_cost,
      ParseNumbers("output_limit_cost", FLAGS_output_limit_cost, p));
  operation.limits = {limits.min_output, limits.max_output};
  const absl::Status status = mpc.Validate(p, model.num_inputs());
  if (status.ok()) return status;
  return absl::InvalidArgumentError(absl::StrCat(
      "controller (--prediction_horizon, --control_horizon, --output_weight, "
      "--move_weight, --disturbance_variance_ratio, --min_input, --max_input, "
      "--min_output, --max_output, --output_limit_cost): ",
      status.message()));
}

}  // namespace

absl::Status SetPeriods(OperationOptions& operation) {
  operation.sample_time = FLAGS_sample_time;
  operation.controller.control_period = FLAGS_control_period;
  if (const absl::Status status =
          sim::CheckPositive("sample_time", FLAGS_sample_time);
      !status.ok()) {
    return Of("sample_time", status);
  }
  const double ratio = FLAGS_control_period / FLAGS_sample_time;
  if (ratio >= 1.0 - 1e-9 && ratio <= 1e9 &&
      std::abs(ratio - std::round(ratio)) <= 1e-9 * ratio) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "--control_period=", FLAGS_control_period,
      ": it must be a whole multiple of --sample_time=", FLAGS_sample_time));
}

absl::Status SetOperation(const ProcessModel& model, const VectorXd& range,
                          double hours_per_unit, OperationOptions& operation) {
  const double settling = SettlingTime(model);
  for (const auto& [flag, value] :
       {std::pair{"window", FLAGS_window},
        std::pair{"quiet_stretch", FLAGS_quiet_stretch},
        std::pair{"warm_up", FLAGS_warm_up}}) {
    if (const absl::Status status = sim::CheckNotNegative(flag, value);
        !status.ok()) {
      return Of(flag, status);
    }
  }
  operation.noise_variance = FLAGS_noise_variance;
  MLE_ASSIGN_OR_RETURN(
      operation.disturbance_deviation,
      ParseNumbers("disturbance_deviation", FLAGS_disturbance_deviation,
                   model.num_outputs()));
  const absl::StatusOr<double> hours = ParseHours(FLAGS_disturbance_time);
  if (!hours.ok()) return Of("disturbance_time", hours.status());
  operation.disturbance_time = *hours / hours_per_unit;
  operation.before = FLAGS_window > 0.0 ? FLAGS_window : 1.5 * settling;
  operation.after = operation.before;
  operation.quiet_stretch =
      FLAGS_quiet_stretch > 0.0 ? FLAGS_quiet_stretch : 3.0 * settling;
  operation.warm_up = FLAGS_warm_up > 0.0 ? FLAGS_warm_up : settling;
  operation.every_sample = FLAGS_every_sample;
  MLE_RETURN_IF_ERROR(SetController(model, range, operation));
  const absl::Status status = operation.Validate(model);
  if (status.ok()) return status;
  // Fields are named as their flags.
  return absl::InvalidArgumentError(absl::StrCat("--", status.message()));
}

}  // namespace mle::lifecycle
