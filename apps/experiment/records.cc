#include <cmath>
#include <utility>

#include "apps/experiment/experiment.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/correction/excitation.h"
#include "sim/closed_loop.h"

namespace mle::experiment {
namespace {

absl::Status AddWindow(const Record& record, double center,
                       const ExperimentOptions& options,
                       std::vector<Record>& windows) {
  MLE_ASSIGN_OR_RETURN(
      Record window,
      CutWindow(record,
                static_cast<int>(std::lround(center / options.sample_time)),
                options.windows.window, options.windows.window));
  windows.push_back(std::move(window));
  return absl::OkStatus();
}

// One run of many changes.
absl::StatusOr<std::vector<Record>> SimulateSequence(
    const control::Mpc& mpc, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options) {
  const WindowSpec& spec = options.windows;
  sim::SetPointProfile set_points;
  std::vector<double> centers;
  const int p = plant.num_outputs();
  for (int change = 0; change < spec.changes; ++change) {
    const double time = spec.window + change * spec.spacing;
    const bool up = (change / p) % 2 == 0;
    set_points.steps.push_back(
        {change % p, time, up ? spec.setpoint_step : 0.0});
    centers.push_back(time);
  }
  MLE_ASSIGN_OR_RETURN(
      const Record record,
      SimulateLoop(mpc, plant, set_points, options.noise_variance, seed,
                   kRunStream, options.conditions, options));
  std::vector<Record> windows;
  for (const double center : centers) {
    MLE_RETURN_IF_ERROR(AddWindow(record, center, options, windows));
  }
  return windows;
}

}  // namespace

absl::StatusOr<ConversionSummary> ConvertInitialModel(
    const ProcessModel& initial, std::uint64_t seed,
    const ExperimentOptions& options) {
  ExcitationOptions excitation;
  excitation.sample_time = options.sample_time;
  excitation.duration = options.conversion_duration;
  excitation.noise_variance =
      options.conversion_noise_variance.value_or(options.noise_variance);
  excitation.seed = seed;
  excitation.stream = kConversionStream;
  MLE_ASSIGN_OR_RETURN(const Record record,
                       SimulateExcitation(initial, excitation));
  return ConvertToArx(record, options.conversion);
}

sim::SetPointProfile StepOf(int output, const WindowSpec& windows) {
  sim::SetPointProfile set_points;
  for (int before = 0; before < output; ++before) {
    set_points.steps.push_back({before, 0.0, windows.setpoint_step});
  }
  set_points.steps.push_back(
      {output, windows.step_time, windows.setpoint_step});
  return set_points;
}

absl::StatusOr<Record> SimulateLoop(control::Mpc mpc, const ProcessModel& plant,
                                    const sim::SetPointProfile& set_points,
                                    double noise_variance, std::uint64_t seed,
                                    std::uint64_t stream,
                                    const sim::PlantConditions& conditions,
                                    const ExperimentOptions& options) {
  sim::ClosedLoopOptions loop;
  loop.sample_time = options.sample_time;
  loop.control_period = options.controller.control_period;
  loop.duration = options.windows.run_duration();
  loop.noise_variance = noise_variance;
  loop.seed = seed;
  loop.stream = stream;
  sim::PlantConditions all = conditions;
  options.effects.AddTo(all);
  sim::SetPointProfile moved = set_points;
  MLE_RETURN_IF_ERROR(
      options.effects.AddTo(moved, loop.duration, seed, stream));
  return sim::SimulateClosedLoop(
      plant,
      [&mpc](const auto& measured, const auto& wanted, auto next) {
        mpc.Step(measured, wanted, next);
      },
      moved, loop, all);
}

absl::StatusOr<std::vector<Record>> SimulateWindows(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options) {
  MLE_ASSIGN_OR_RETURN(const control::Mpc mpc,
                       control::Mpc::Create(initial, options.controller));
  if (options.windows.changes > 0) {
    return SimulateSequence(mpc, plant, seed, options);
  }
  std::vector<Record> windows;
  for (int e = 0; e < plant.num_outputs(); ++e) {
    MLE_ASSIGN_OR_RETURN(const Record record,
                         SimulateLoop(mpc, plant, StepOf(e, options.windows),
                                      options.noise_variance, seed,
                                      static_cast<std::uint64_t>(e),
                                      options.conditions, options));
    MLE_RETURN_IF_ERROR(
        AddWindow(record, options.windows.step_time, options, windows));
  }
  return windows;
}

}  // namespace mle::experiment
