#include "apps/reproduce/experiment.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "apps/reproduce/distance_curve.h"
#include "control/prediction_model.h"
#include "control/retuning.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/correction/excitation.h"
#include "mle/data/record.h"
#include "sim/closed_loop.h"

namespace mle::reproduce {
namespace {}  // namespace

absl::StatusOr<std::vector<Record>> SimulateWindows(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options) {
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
                         control::Mpc::Create(initial, MpcOptionsOf(options)));
    sim::SetPointProfile set_points;
    for (int before = 0; before < e; ++before) {
      set_points.steps.push_back({before, 0.0, options.setpoint_step});
    }
    set_points.steps.push_back({e, options.step_time, options.setpoint_step});
    loop.stream = kRunStream + static_cast<std::uint64_t>(e);
    MLE_ASSIGN_OR_RETURN(
        const Record record,
        sim::SimulateClosedLoop(
            plant,
            [&mpc](const auto& measured, const auto& wanted, auto next) {
              mpc.Step(measured, wanted, next);
            },
            set_points, loop, options.conditions));
    MLE_ASSIGN_OR_RETURN(
        Record window,
        CutWindow(record, center, options.window, options.window));
    windows.push_back(std::move(window));
  }
  return windows;
}

namespace {

// The corrected model's responses must have settled: they are followed for
// longer than they are compared.
constexpr int kSettlingHorizons = 5;

std::vector<std::string> AdviseOnTuning(const ProcessModel& initial,
                                        const ArxModel& corrected,
                                        const ExperimentOptions& options) {
  const auto old_model =
      control::PredictFromProcess(initial, options.control_period);
  if (!old_model.ok()) return {std::string(old_model.status().message())};
  control::RetuningOptions retuning;
  retuning.time_unit = initial.time_unit();
  for (const OutputChannel& output : initial.outputs()) {
    retuning.output_names.push_back(output.name);
  }
  for (const InputChannel& input : initial.inputs()) {
    retuning.input_names.push_back(input.name);
  }
  const auto advice = control::AdviseRetuning(
      *old_model, MpcOptionsOf(options),
      corrected.ComputeStepResponse(
          kSettlingHorizons * (options.response_samples() - 1) + 1),
      retuning);
  if (!advice.ok()) return {std::string(advice.status().message())};
  return advice->reasons;
}

absl::Status AddOtherRule(const Correction& correction,
                          const SelectionOptions& used,
                          const StepResponse& truth, RunResult& run) {
  const bool paper =
      used.rule == SelectionOptions::Rule::kLeaveChangeOut && used.on_grid;
  SelectionOptions other;
  if (!paper) {
    other.rule = SelectionOptions::Rule::kLeaveChangeOut;
    other.horizon = 1;
    other.on_grid = true;
  }
  MLE_ASSIGN_OR_RETURN(const SelectionSummary selection,
                       correction.Select(other));
  run.max_relative_gap =
      std::max(run.max_relative_gap, selection.max_relative_gap);
  run.other_rule = RunResult::OtherRule{
      paper ? "blocks" : "paper", selection.lambda_star(0),
      DistanceOrInfinity(truth, correction.Model(selection.lambda_star)
                                    .ComputeStepResponse(truth.samples()))};
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ConversionSummary> ConvertInitialModel(
    const ProcessModel& initial, std::uint64_t seed,
    const ExperimentOptions& options) {
  ExcitationOptions excitation;
  excitation.sample_time = options.sample_time;
  excitation.duration = options.conversion_duration;
  excitation.noise_variance = options.conversion_noise_variance;
  excitation.seed = seed;
  excitation.stream = kConversionStream;
  MLE_ASSIGN_OR_RETURN(const Record record,
                       SimulateExcitation(initial, excitation));
  return ConvertToArx(record, options.conversion);
}

absl::StatusOr<RunResult> RunExperiment(const ProcessModel& initial,
                                        const ProcessModel& plant,
                                        const ConversionSummary& conversion,
                                        std::uint64_t seed, bool in_full,
                                        const ExperimentOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<Record> windows,
                       SimulateWindows(initial, plant, seed, options));
  const double start = ThreadSeconds();
  MLE_ASSIGN_OR_RETURN(
      const Correction correction,
      CorrectModel(conversion.model, windows, options.correction));
  const double correction_seconds = ThreadSeconds() - start;

  const StepResponse truth = plant.ComputeStepResponse(
      options.sample_time, options.response_samples());
  RunResult run;
  run.seed = seed;
  run.selection = correction.selection();
  run.lambda_star = run.selection.lambda_star(0);
  run.max_relative_gap =
      std::max(conversion.max_relative_gap, correction.MaxRelativeGap());
  DistanceCurve curve(correction, options.correction.lambdas, truth);
  if (in_full) run.squared_distance = curve.Whole();
  const Eigen::Index best = curve.Best();
  run.lambda_oracle = options.correction.lambdas(best);
  run.E_oracle = curve(best);
  run.corrected = correction.Model().ComputeStepResponse(truth.samples());
  run.unregularised =
      correction.Model(0.0).ComputeStepResponse(truth.samples());
  run.E_zero = DistanceOrInfinity(truth, run.unregularised);
  if (!std::isfinite(DistanceOrInfinity(truth, run.corrected))) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the model corrected with λ* = %g is unstable: its step response "
        "leaves the range of numbers within %g",
        run.lambda_star, options.response_horizon));
  }
  MLE_ASSIGN_OR_RETURN(run.judgement, Judge(truth, run.corrected));
  run.E_star = run.judgement.squared_distance;
  MLE_ASSIGN_OR_RETURN(
      run.closed_loop,
      CompareClosedLoops(initial, correction.Model(), plant, seed, in_full,
                         MpcOptionsOf(options), options));
  run.estimators =
      CompareEstimators(initial, plant, windows, correction, correction_seconds,
                        seed, in_full, options);
  if (in_full) {
    run.retuning = AdviseOnTuning(initial, correction.Model(), options);
  }
  if (in_full && windows.size() > 1) {
    MLE_RETURN_IF_ERROR(
        AddOtherRule(correction, options.correction.selection, truth, run));
  }
  return run;
}

}  // namespace mle::reproduce
