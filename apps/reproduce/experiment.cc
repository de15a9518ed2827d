#include "apps/reproduce/experiment.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "control/mpc.h"
#include "mle/base/status.h"
#include "mle/data/record.h"
#include "sim/closed_loop.h"
#include "sim/excitation.h"

namespace mle::reproduce {
namespace {

// Noise streams of a seed: the loops take 0, 1, …, p − 1.
constexpr std::uint64_t kConversionStream = 1'000'000;

absl::StatusOr<std::vector<Record>> SimulateWindows(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options) {
  control::MpcOptions mpc_options;
  mpc_options.control_period = options.control_period;
  mpc_options.prediction_horizon = options.prediction_horizon;
  mpc_options.control_horizon = options.control_horizon;
  mpc_options.output_weight = options.output_weight.asDiagonal();
  mpc_options.move_weight = options.move_weight.asDiagonal();
  mpc_options.disturbance_variance_ratio = options.disturbance_variance_ratio;

  sim::ClosedLoopOptions loop;
  loop.sample_time = options.sample_time;
  loop.control_period = options.control_period;
  loop.duration = options.duration;
  loop.noise_variance = options.noise_variance;
  loop.seed = seed;

  const int center =
      static_cast<int>(std::lround(options.step_time / options.sample_time));
  std::vector<Record> windows;
  for (int e = 0; e < plant.num_outputs(); ++e) {
    MLE_ASSIGN_OR_RETURN(control::Mpc mpc,
                         control::Mpc::Create(initial, mpc_options));
    sim::SetPointProfile set_points;
    for (int before = 0; before < e; ++before) {
      set_points.steps.push_back({before, 0.0, options.setpoint_step});
    }
    set_points.steps.push_back({e, options.step_time, options.setpoint_step});
    loop.stream = static_cast<std::uint64_t>(e);
    MLE_ASSIGN_OR_RETURN(
        const Record record,
        sim::SimulateClosedLoop(
            plant,
            [&mpc](const auto& measured, const auto& wanted, auto next) {
              mpc.Step(measured, wanted, next);
            },
            set_points, loop));
    MLE_ASSIGN_OR_RETURN(
        Record window,
        CutWindow(record, center, options.window, options.window));
    windows.push_back(std::move(window));
  }
  return windows;
}

// E at every λ of the grid, and the best of them.
void Search(const Correction& correction, const Eigen::VectorXd& lambdas,
            const StepResponse& truth, const ArxModel& initial,
            RunResult& run) {
  ArxModel model = initial;
  run.squared_distance.resize(lambdas.size());
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    correction.Model(lambdas(i), model);
    run.squared_distance(i) =
        SquaredDistance(truth, model.ComputeStepResponse(truth.samples()));
  }
  Eigen::Index best = 0;
  run.E_oracle = run.squared_distance.minCoeff(&best);
  run.lambda_oracle = lambdas(best);
}

absl::Status CheckPositive(const char* flag, double value) {
  if (value > 0.0 && std::isfinite(value)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("--%s=%g: it must be positive", flag, value));
}

absl::Status CheckNotNegative(const char* flag, double value) {
  if (value >= 0.0 && std::isfinite(value)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("--%s=%g: it must not be negative", flag, value));
}

}  // namespace

absl::Status ExperimentOptions::Validate(const ProcessModel& initial) const {
  MLE_RETURN_IF_ERROR(CheckPositive("sample_time", sample_time));
  MLE_RETURN_IF_ERROR(CheckPositive("control_period", control_period));
  MLE_RETURN_IF_ERROR(CheckPositive("duration", duration));
  MLE_RETURN_IF_ERROR(CheckPositive("window", window));
  MLE_RETURN_IF_ERROR(
      CheckPositive("conversion_duration", conversion_duration));
  MLE_RETURN_IF_ERROR(CheckPositive("response_horizon", response_horizon));
  MLE_RETURN_IF_ERROR(CheckNotNegative("step_time", step_time));
  MLE_RETURN_IF_ERROR(CheckNotNegative("noise_variance", noise_variance));
  MLE_RETURN_IF_ERROR(
      CheckNotNegative("conversion_noise_variance", conversion_noise_variance));
  MLE_RETURN_IF_ERROR(CheckNotNegative("disturbance_variance_ratio",
                                       disturbance_variance_ratio));
  if (setpoint_step == 0.0 || !std::isfinite(setpoint_step)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--setpoint_step=%g: the set points must change by a finite step",
        setpoint_step));
  }
  const double ratio = control_period / sample_time;
  if (std::round(ratio) < 1.0 ||
      std::abs(ratio - std::round(ratio)) > 1e-9 * ratio) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--control_period=%g is no whole multiple of --sample_time=%g",
        control_period, sample_time));
  }
  if (control_horizon < 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--control_horizon=%d: it must be at least 1", control_horizon));
  }
  if (prediction_horizon < control_horizon) {
    return absl::InvalidArgumentError(
        absl::StrFormat("--control_horizon=%d exceeds --prediction_horizon=%d",
                        control_horizon, prediction_horizon));
  }
  if (output_weight.size() != initial.num_outputs() ||
      move_weight.size() != initial.num_inputs()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--output_weight has %d values for %d outputs, --move_weight %d for %d "
        "inputs",
        output_weight.size(), initial.num_outputs(), move_weight.size(),
        initial.num_inputs()));
  }
  if (!(output_weight.minCoeff() >= 0.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--output_weight: %g is negative; the weight Q_y must be positive "
        "semi-definite",
        output_weight.minCoeff()));
  }
  if (!(move_weight.minCoeff() >= 0.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--move_weight: %g is negative; the weight Q_u must be positive "
        "semi-definite",
        move_weight.minCoeff()));
  }
  if (step_time - window < -1e-9 || step_time + window > duration + 1e-9) {
    return absl::OutOfRangeError(absl::StrFormat(
        "--window=%g around --step_time=%g reaches from %g to %g, the record "
        "from 0 to --duration=%g",
        window, step_time, step_time - window, step_time + window, duration));
  }
  if (response_horizon / sample_time > 1e7 || duration / sample_time > 1e8 ||
      conversion_duration / sample_time > 1e8) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--sample_time=%g is too small: --duration=%g, "
        "--conversion_duration=%g or --response_horizon=%g would have too many "
        "samples",
        sample_time, duration, conversion_duration, response_horizon));
  }
  const double rows = 2.0 * window / sample_time + 1.0 - conversion.order;
  if (conversion.order >= 1 && rows < 2.0) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--order=%d leaves no rows to learn from: a window of 2 × %g has %d "
        "samples",
        conversion.order, window,
        static_cast<int>(2.0 * window / sample_time) + 1));
  }
  for (const InputChannel& input : initial.inputs()) {
    if (input.role == InputRole::kDisturbance) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "input '%s' is a disturbance; this experiment moves every input",
          input.name));
    }
  }
  MLE_RETURN_IF_ERROR(conversion.Validate());
  return correction.Validate();
}

int ExperimentOptions::response_samples() const {
  return static_cast<int>(std::lround(response_horizon / sample_time)) + 1;
}

absl::StatusOr<ConversionSummary> ConvertInitialModel(
    const ProcessModel& initial, std::uint64_t seed,
    const ExperimentOptions& options) {
  sim::ExcitationOptions excitation;
  excitation.sample_time = options.sample_time;
  excitation.duration = options.conversion_duration;
  excitation.noise_variance = options.conversion_noise_variance;
  excitation.seed = seed;
  excitation.stream = kConversionStream;
  MLE_ASSIGN_OR_RETURN(const Record record,
                       sim::SimulateExcitation(initial, excitation));
  return ConvertToArx(record, options.conversion);
}

absl::StatusOr<RunResult> RunExperiment(const ProcessModel& initial,
                                        const ProcessModel& plant,
                                        const ConversionSummary& conversion,
                                        std::uint64_t seed,
                                        const ExperimentOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<Record> windows,
                       SimulateWindows(initial, plant, seed, options));
  MLE_ASSIGN_OR_RETURN(
      const Correction correction,
      CorrectModel(conversion.model, windows, options.correction));

  const StepResponse truth = plant.ComputeStepResponse(
      options.sample_time, options.response_samples());
  RunResult run;
  run.seed = seed;
  run.selection = correction.selection();
  run.max_relative_gap =
      std::max(conversion.max_relative_gap, correction.MaxRelativeGap());
  Search(correction, options.correction.lambdas, truth, conversion.model, run);
  run.corrected = correction.Model(run.selection.lambda_star)
                      .ComputeStepResponse(truth.samples());
  run.unregularised =
      correction.Model(0.0).ComputeStepResponse(truth.samples());
  run.E_zero = SquaredDistance(truth, run.unregularised);
  MLE_ASSIGN_OR_RETURN(run.judgement, Judge(truth, run.corrected));
  run.E_star = run.judgement.squared_distance;
  return run;
}

}  // namespace mle::reproduce
