#include "tests/apps/reproduce/example_case.h"

namespace mle::reproduce {
namespace {

constexpr double kSampleTime = 0.5;
constexpr int kSamples = 41;

RunResult ExampleRun(const ProcessModel& plant, double static_gain_error,
                     double impulse_peak, double fit_gain_error) {
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  RunResult run;
  run.judgement.static_gain_error.setConstant(p, m, static_gain_error);
  run.judgement.delay_impulse_peak.setConstant(p, m, impulse_peak);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      FopdtFit fit;
      fit.gain = plant.element(i, j).StaticGain() + fit_gain_error;
      fit.time_constant = 5.0;
      fit.delay = plant.element(i, j).delay() + 0.5;
      run.judgement.fopdt.push_back(fit);
    }
  }
  run.selection.lambda_star = Eigen::VectorXd::Zero(p);
  run.corrected = plant.ComputeStepResponse(kSampleTime, kSamples);
  run.unregularised = run.corrected;
  return run;
}

}  // namespace

ProcessModel ExampleModel(double gain_change, double delay_change) {
  ProcessModel model("example", "s", {{"u, 1", ""}, {"u \"2\"", ""}, {"ü", ""}},
                     {{"y", ""}, {"z", ""}});
  for (int i = 0; i < 2; ++i) {
    for (int j = i; j < 3; j += 2) {
      model.element(i, j) =
          TransferFunction::FirstOrder(10.0 * (i + 1) + j + 1, 5.0, 2.0);
    }
  }
  model.element(0, 0) =
      TransferFunction::FirstOrder(11.0 + gain_change, 5.0, 2.0 + delay_change);
  return model;
}

CaseResult ExampleCase() {
  CaseResult result;
  result.name = "gain";
  result.plant = ExampleModel(-1.0, 3.0);
  result.truth = result.plant.ComputeStepResponse(kSampleTime, kSamples);
  result.initial =
      ExampleModel(0.0, 0.0).ComputeStepResponse(kSampleTime, kSamples);
  result.E_initial = 100.0;
  result.runs.push_back(ExampleRun(result.plant, 0.3, 2.0, 0.6));
  result.runs.push_back(ExampleRun(result.plant, -0.4, 4.0, 0.8));
  RunResult& first = result.runs[0];
  RunResult& second = result.runs[1];
  first.seed = 5;
  first.E_star = 3.0;
  first.E_zero = 30.0;
  first.E_oracle = 1.0;
  first.lambda_star = 2e-4;
  first.max_relative_gap = 1e-12;
  second.seed = 6;
  second.E_star = 4.0;
  second.E_zero = 10.0;
  second.E_oracle = 2.0;
  second.lambda_star = 4e-4;
  second.max_relative_gap = 3e-11;
  return result;
}

}  // namespace mle::reproduce
