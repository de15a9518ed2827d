#include "apps/reproduce/run.h"

#include "apps/experiment/distance_curve.h"
#include "control/prediction_model.h"
#include "control/retuning.h"
#include "mle/base/status.h"

namespace mle::reproduce {
namespace {

using experiment::Evaluation;
using experiment::Experiment;
using experiment::ExperimentOptions;

// The corrected model's responses must have settled: they are followed for
// longer than they are compared.
constexpr int kSettlingHorizons = 5;

std::vector<std::string> AdviseOnTuning(const ProcessModel& initial,
                                        const ArxModel& corrected,
                                        const ExperimentOptions& options) {
  const auto old_model =
      control::PredictFromProcess(initial, options.controller.control_period);
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
      *old_model, options.controller,
      corrected.ComputeStepResponse(
          kSettlingHorizons * (options.response_samples() - 1) + 1),
      retuning);
  if (!advice.ok()) return {std::string(advice.status().message())};
  return advice->reasons;
}

}  // namespace

absl::Status FillRun(const Experiment& experiment, const Evaluation& evaluation,
                     bool in_full, RunResult& run) {
  const Correction& correction = *evaluation.estimate->fit.arx;
  const experiment::Hindsight& hindsight = *evaluation.hindsight;
  const StepResponse& truth = experiment.truth();
  run.selection = correction.selection();
  run.lambda_star = evaluation.lambda(0);
  run.max_relative_gap = evaluation.max_relative_gap;
  run.lambda_oracle = hindsight.best_lambda;
  run.E_oracle = hindsight.best_E;
  run.judgement = evaluation.judgement;
  run.E_star = evaluation.E();
  const StepResponse unregularised =
      correction.Model(0.0).ComputeStepResponse(truth.samples());
  run.E_zero = experiment::DistanceOrInfinity(truth, unregularised);
  const ArxModel corrected = correction.Model();
  MLE_ASSIGN_OR_RETURN(
      run.closed_loop,
      CompareClosedLoops(experiment.initial(), corrected, experiment.plant(),
                         experiment.seed(), in_full, experiment.options()));
  if (!in_full) {
    // The curves of all seeds would fill the memory.
    run.selection.loss.resize(0);
    run.selection.penalised_loss.resize(0);
    return absl::OkStatus();
  }
  run.squared_distance =
      experiment::DistanceCurve(correction, correction.fits().front().lambdas,
                                truth)
          .Whole();
  run.corrected = evaluation.response;
  run.unregularised = unregularised;
  run.retuning =
      AdviseOnTuning(experiment.initial(), corrected, experiment.options());
  return absl::OkStatus();
}

}  // namespace mle::reproduce
