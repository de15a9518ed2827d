#include "apps/experiment/options.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/controller_options.h"
#include "apps/common/option_table.h"
#include "control/mpc.h"
#include "mle/base/status.h"

namespace mle::experiment {
namespace {

absl::Status CheckTimes(const ExperimentOptions& options) {
  for (const auto& [flag, value] :
       {std::pair{"control_period", options.controller.control_period},
        std::pair{"duration", options.windows.run_duration()},
        std::pair{"window", options.windows.window},
        std::pair{"conversion_duration", options.conversion_duration},
        std::pair{"response_horizon", options.response_horizon}}) {
    MLE_RETURN_IF_ERROR(CheckSamples(flag, value, options.sample_time));
  }
  if (options.windows.setpoint_step != 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--setpoint_step=0: it must be other than 0");
}

absl::Status CheckLoop(const ExperimentOptions& options,
                       const ProcessModel& initial) {
  const control::MpcOptions& controller = options.controller;
  MLE_RETURN_IF_ERROR(
      CheckControlPeriod(controller.control_period, options.sample_time));
  if (controller.prediction_horizon < controller.control_horizon) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--control_horizon=%d exceeds --prediction_horizon=%d",
        controller.control_horizon, controller.prediction_horizon));
  }
  for (const InputChannel& input : initial.inputs()) {
    if (input.role == InputRole::kDisturbance) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "input '%s' is a disturbance; this experiment moves every input",
          input.name));
    }
  }
  MLE_RETURN_IF_ERROR(CheckController(controller, initial));
  // Finds the rest, such as weights that leave the moves undetermined.
  const absl::Status created =
      control::Mpc::Create(initial, controller).status();
  if (created.ok()) return created;
  return absl::InvalidArgumentError(
      absl::StrCat("controller: ", created.message()));
}

absl::Status CheckRows(const ExperimentOptions& options,
                       const ProcessModel& initial) {
  const double first = options.windows.first_change();
  const double window = options.windows.window;
  const double duration = options.windows.run_duration();
  if (!(first - window >= -1e-9) || !(first + window <= duration + 1e-9)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--window=%g around --step_time=%g reaches from %g to %g, the record "
        "from 0 to --duration=%g",
        window, first, first - window, first + window, duration));
  }
  const int order = options.conversion.order;
  if (options.window_rows() < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--order=%d leaves no rows to learn from: a window of 2 × %g has %d "
        "samples",
        order, window, options.window_rows() + order));
  }
  const double rows =
      std::round(options.conversion_duration / options.sample_time) + 1 - order;
  const double regressors = static_cast<double>(order) *
                            (initial.num_outputs() + initial.num_inputs());
  if (rows < regressors) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--conversion_duration=%g is too short: --order=%d makes %d "
        "coefficients of each output, which take at least %g",
        options.conversion_duration, order, static_cast<long>(regressors),
        (regressors + order) * options.sample_time));
  }
  constexpr int kFewestSamples = 5;  // that a fit of three parameters needs
  if (options.response_samples() < kFewestSamples) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--response_horizon=%g is too short; it must be at least %g, %d times "
        "--sample_time",
        options.response_horizon, (kFewestSamples - 1) * options.sample_time,
        kFewestSamples - 1));
  }
  return absl::OkStatus();
}

absl::Status CheckSelection(const ExperimentOptions& options,
                            const ProcessModel& initial) {
  const SelectionOptions& selection = options.correction.selection;
  const int windows = options.windows.num_changes(initial.num_outputs());
  if (selection.rule == SelectionOptions::Rule::kLeaveChangeOut) {
    if (windows >= 2) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrFormat(
        "--selection=paper and leave_change_out need at least two set-point "
        "changes, one to leave out, not %d: use --selection=blocks",
        windows));
  }
  if (selection.rule != SelectionOptions::Rule::kBlocks)
    return absl::OkStatus();
  const int length = selection.BlockLength(options.conversion.order);
  const int blocks = std::max(options.window_rows() / length, 1) * windows;
  if (blocks < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--selection_block=%d samples makes a single block of the records, "
        "which have %d rows; cross-validation needs at least 2",
        length, options.window_rows() * windows));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckControlPeriod(double control_period, double sample_time) {
  const double ratio = control_period / sample_time;
  if (std::round(ratio) >= 1.0 &&
      std::abs(ratio - std::round(ratio)) <= 1e-9 * ratio) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrFormat(
      "--control_period=%g is not a whole multiple of --sample_time=%g",
      control_period, sample_time));
}

absl::Status ExperimentOptions::Validate(const ProcessModel& initial) const {
  MLE_RETURN_IF_ERROR(CheckTimes(*this));
  MLE_RETURN_IF_ERROR(CheckLoop(*this, initial));
  MLE_RETURN_IF_ERROR(CheckRows(*this, initial));
  MLE_RETURN_IF_ERROR(CheckSelection(*this, initial));
  MLE_RETURN_IF_ERROR(conversion.Validate());
  return correction.Validate();
}

int ExperimentOptions::response_samples() const {
  return static_cast<int>(std::lround(response_horizon / sample_time)) + 1;
}

int ExperimentOptions::window_rows() const {
  return 2 * static_cast<int>(std::lround(windows.window / sample_time)) + 1 -
         conversion.order;
}

}  // namespace mle::experiment
