#include "apps/study/scenario.h"

#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/study/plants.h"
#include "control/mpc.h"
#include "mle/base/status.h"
#include "sim/closed_loop.h"
#include "sim/set_point_profile.h"

namespace mle::study {
namespace {

using reproduce::ExperimentOptions;

// A model of so many channels that is easy to control, to check options with.
ProcessModel StandIn(const RandomPlants& plants) {
  std::vector<InputChannel> inputs(plants.inputs);
  std::vector<OutputChannel> outputs(plants.outputs);
  for (int j = 0; j < plants.inputs; ++j) inputs[j].name = absl::StrCat("u", j);
  for (int i = 0; i < plants.outputs; ++i) {
    outputs[i].name = absl::StrCat("y", i);
  }
  ProcessModel model("stand-in", "min", inputs, outputs);
  for (int i = 0; i < plants.outputs; ++i) {
    for (int j = 0; j < plants.inputs; ++j) {
      model.element(i, j) = TransferFunction::FirstOrder(
          i == j ? plants.gain.to : plants.gain.from, plants.time_constant.from,
          plants.delay.from);
    }
  }
  return model;
}

absl::Status CheckScenario(const Campaign& campaign, const Scenario& scenario) {
  const ModelSpec& spec = campaign.models[scenario.model];
  const ProcessModel model =
      spec.random.has_value() ? StandIn(*spec.random) : spec.model;
  MLE_ASSIGN_OR_RETURN(
      ExperimentOptions options,
      OptionsOf(campaign, scenario, model.num_outputs(), model.num_inputs()));
  const int wanted = campaign.windows[scenario.windows].changes;
  const int changes = wanted > 0 ? wanted : model.num_outputs();
  MLE_RETURN_IF_ERROR(options.Validate(model));
  for (const SelectionSpec& selection : campaign.selections) {
    if (selection.options.rule == SelectionOptions::Rule::kLeaveChangeOut) {
      // The experiment's own check counts a change for each output.
      if (changes >= 2) continue;
      return absl::InvalidArgumentError(absl::StrCat(
          "the selection '", selection.name,
          "' leaves a change out, which needs at least 2 changes, not 1"));
    }
    options.correction.selection = selection.options;
    MLE_RETURN_IF_ERROR(options.Validate(model));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ExperimentOptions> OptionsOf(const Campaign& campaign,
                                            const Scenario& scenario,
                                            int outputs, int inputs) {
  const ControllerSpec& controller = campaign.controllers[scenario.controller];
  const WindowSpec& windows = campaign.windows[scenario.windows];
  MLE_ASSIGN_OR_RETURN(const control::MpcOptions mpc,
                       MpcOptionsOf(controller, outputs, inputs));
  ExperimentOptions options;
  options.sample_time = campaign.sample_time;
  options.control_period = controller.control_period;
  options.prediction_horizon = controller.prediction_horizon;
  options.control_horizon = controller.control_horizon;
  options.output_weight = mpc.output_weight.diagonal();
  options.move_weight = mpc.move_weight.diagonal();
  options.disturbance_variance_ratio = controller.disturbance_variance_ratio;
  options.noise_variance = campaign.noise_variances[scenario.noise];
  const double drift = campaign.drift_variances[scenario.drift];
  if (drift > 0.0) {
    options.conditions.output_disturbance.drift_variance =
        Eigen::VectorXd::Constant(outputs, drift);
  }
  options.setpoint_step = windows.setpoint_step;
  options.window = windows.window;
  if (windows.changes > 0) {
    options.step_time = windows.window;
    options.duration =
        2.0 * windows.window + (windows.changes - 1) * windows.spacing;
  } else {
    options.step_time = windows.step_time;
    options.duration = windows.duration;
  }
  options.conversion_duration = campaign.conversion_duration;
  options.conversion_noise_variance =
      campaign.conversion_noise_variance.value_or(options.noise_variance);
  options.conversion.order = campaign.order;
  options.conversion.penalty = campaign.conversion_penalty;
  options.conversion.scaling = campaign.scaling;
  options.correction.lambdas = campaign.lambdas;
  options.correction.scaling = campaign.scaling;
  options.response_horizon = campaign.response_horizon;
  return options;
}

absl::Status CheckScenarios(const Campaign& campaign) {
  Scenario scenario;
  for (scenario.model = 0;
       scenario.model < static_cast<int>(campaign.models.size());
       ++scenario.model) {
    for (scenario.controller = 0;
         scenario.controller < static_cast<int>(campaign.controllers.size());
         ++scenario.controller) {
      for (scenario.windows = 0;
           scenario.windows < static_cast<int>(campaign.windows.size());
           ++scenario.windows) {
        const absl::Status status = CheckScenario(campaign, scenario);
        if (status.ok()) continue;
        // The experiment names flags of mle_reproduce; the keys are called the
        // same.
        return absl::InvalidArgumentError(absl::StrCat(
            "model '", campaign.models[scenario.model].name, "', controller '",
            campaign.controllers[scenario.controller].name, "', windows '",
            campaign.windows[scenario.windows].name,
            "': ", absl::StrReplaceAll(status.message(), {{"--", ""}})));
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Record>> SimulateChanges(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const WindowSpec& windows, const ExperimentOptions& options) {
  if (windows.changes == 0) {
    return reproduce::SimulateWindows(initial, plant, seed, options);
  }
  sim::ClosedLoopOptions loop;
  loop.sample_time = options.sample_time;
  loop.control_period = options.control_period;
  loop.duration = options.duration;
  loop.noise_variance = options.noise_variance;
  loop.seed = seed;
  sim::SetPointProfile set_points;
  std::vector<double> centers;
  const int p = plant.num_outputs();
  for (int change = 0; change < windows.changes; ++change) {
    const double time = windows.window + change * windows.spacing;
    const bool up = (change / p) % 2 == 0;
    set_points.steps.push_back(
        {change % p, time, up ? windows.setpoint_step : 0.0});
    centers.push_back(time);
  }
  MLE_ASSIGN_OR_RETURN(
      control::Mpc mpc,
      control::Mpc::Create(initial, reproduce::MpcOptionsOf(options)));
  MLE_ASSIGN_OR_RETURN(
      const Record record,
      sim::SimulateClosedLoop(
          plant,
          [&mpc](const auto& measured, const auto& wanted, auto next) {
            mpc.Step(measured, wanted, next);
          },
          set_points, loop, options.conditions));
  std::vector<Record> cut;
  for (const double center : centers) {
    MLE_ASSIGN_OR_RETURN(
        Record window,
        CutWindow(record,
                  static_cast<int>(std::lround(center / options.sample_time)),
                  windows.window, windows.window));
    cut.push_back(std::move(window));
  }
  return cut;
}

}  // namespace mle::study
