#include "apps/simulate/flags.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/loop_flags.h"
#include "apps/simulate/named_values.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"
#include "sim/ageing_json.h"
#include "sim/ageing_plant.h"
#include "sim/continuous_plant.h"
#include "sim/van_de_vusse.h"

DEFINE_string(model, "", "Process model (JSON) of the controller.");
DEFINE_string(plant, "",
              "The plant: a process model (JSON) with the same inputs and "
              "outputs, or van_de_vusse, a stirred tank reactor (non-linear, "
              "time in h). Empty: --model.");
DEFINE_string(
    operating_inputs, "8,-1113.5",
    "Feed (1/h) and heat (kJ/h) of the steady state at which van_de_vusse "
    "starts; the record has deviations from that state.");
DEFINE_string(ageing, "",
              "Ageing schedule (JSON) of the plant's elements: gains, time "
              "constants and dead times over time.");
DEFINE_double(age, 0.0,
              "Time of --ageing at which the run begins, in the model's time "
              "unit (min).");
DEFINE_string(setpoints, "",
              "NAME:TIME:VALUE,… set points of outputs: VALUE from TIME on, 0 "
              "before the first change.");
DEFINE_double(duration, 1000.0, "Length of the run (min).");
DEFINE_uint64(seed, 1, "Seed of all random numbers.");
DEFINE_string(out, "", "The record to be written (CSV). Must be given.");

DEFINE_string(min_input, "",
              "Lower limits of the inputs in the controller: one value, or one "
              "for each input; none: no limit. Empty: no limits.");
DEFINE_string(max_input, "",
              "Upper limits of the inputs in the controller, as --min_input.");
DEFINE_string(max_move, "",
              "Largest move of each input in a control period, > 0, as "
              "--min_input.");
DEFINE_string(min_output, "",
              "Lower limits of the outputs in the controller (soft): one "
              "value, or one for each output; none: no limit.");
DEFINE_string(
    max_output, "",
    "Upper limits of the outputs in the controller (soft), as --min_output.");
DEFINE_string(output_limit_cost, "1000",
              "Weight of the squared violation of an output limit, > 0: one "
              "value, or one for each output.");
DEFINE_bool(feed_forward, true,
            "The controller uses measurements of the inputs with the role of "
            "disturbances.");
DEFINE_bool(preview, false, "The controller knows future set points.");

DEFINE_string(coloured_variance, "0",
              "Variance of a coloured disturbance of the outputs, ≥ 0: one "
              "value, or one for each output.");
DEFINE_double(coloured_time_constant, 10.0,
              "Correlation time of the coloured disturbance, > 0 (min).");
DEFINE_string(
    drift_variance, "0",
    "Variance q of the increments per sample of a random-walk disturbance of "
    "the outputs, ≥ 0: one value, or one for each output.");
DEFINE_double(disturbance_step_rate, 0.0,
              "Mean number of step disturbances of an output per unit of time "
              "(1/min), ≥ 0.");
DEFINE_string(disturbance_step_deviation, "0",
              "Standard deviation of a step disturbance, ≥ 0: one value, or "
              "one for each output.");
DEFINE_string(disturbances, "",
              "NAME:TIME:VALUE,… steps of inputs with the role of "
              "disturbances: VALUE from TIME on, 0 before the first step.");
DEFINE_string(
    disturbance_variance, "0",
    "Variance of coloured noise on the inputs with the role of disturbances, ≥ "
    "0: one value, or one for each input of the model.");
DEFINE_double(disturbance_time_constant, 10.0,
              "Correlation time of that noise on the inputs, > 0 (min).");
DEFINE_string(valve_min, "",
              "Lower limits of the plant's valves, which the controller does "
              "not know; as --min_input.");
DEFINE_string(valve_max, "",
              "Upper limits of the plant's valves, as --valve_min.");

DEFINE_double(outlier_probability, 0.0,
              "Probability that a measured sample of an output is an outlier.");
DEFINE_string(
    outlier_size, "0",
    "Largest outlier, ≥ 0; the size of an outlier is uniform between a fifth "
    "of this value and this value. One value, or one for each output.");
DEFINE_string(quantum, "0",
              "Quantum of the measured outputs; 0: no rounding. One value, or "
              "one for each output.");
DEFINE_double(freeze_rate, 0.0,
              "Mean number of times a measured output freezes per unit of time "
              "(1/min), ≥ 0.");
DEFINE_double(
    freeze_duration, 10.0,
    "Mean duration for which a measured output is frozen, > 0 (min).");
DEFINE_double(lost_probability, 0.0,
              "Probability that a sample of an output is lost.");
DEFINE_double(lost_input_probability, 0.0,
              "Probability that a sample of an input is lost in the record.");
DEFINE_bool(
    faults_only_in_record, false,
    "Outliers, rounding, frozen and lost samples occur in the historian; the "
    "controller receives the measurements without these faults.");

namespace mle::simulate {
namespace {

using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr char kReactor[] = "van_de_vusse";

absl::Status Of(const char* flag, const absl::Status& status) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, ": ", status.message()));
}

template <typename Channel>
std::vector<std::string> NamesOf(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name);
  return names;
}

absl::StatusOr<ProcessModel> ReadModelOf(const char* flag,
                                         const std::string& path) {
  absl::StatusOr<ProcessModel> model = ReadProcessModel(path);
  if (!model.ok()) return Of(flag, model.status());
  return model;
}

absl::StatusOr<std::unique_ptr<sim::PlantModel>> MakeReactor(
    const ProcessModel& model) {
  if (!FLAGS_ageing.empty()) {
    return absl::InvalidArgumentError(
        "--ageing is for plants that are process models, not for "
        "--plant=van_de_vusse");
  }
  const ProcessModel channels("reactor", "h", {{"feed", ""}, {"heat", ""}},
                              {{"product", ""}, {"temperature", ""}});
  MLE_RETURN_IF_ERROR(
      CheckSameChannels(model, FLAGS_model, channels, kReactor));
  const std::vector<std::string> inputs = ParseList(FLAGS_operating_inputs);
  if (inputs.size() != 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("--operating_inputs=", FLAGS_operating_inputs,
                     ": the feed and the heat are needed"));
  }
  MLE_ASSIGN_OR_RETURN(
      const VectorXd operating,
      ParseNumbers("operating_inputs", FLAGS_operating_inputs, 2));
  absl::StatusOr<sim::ContinuousSystem> system =
      sim::MakeVanDeVusseReactor({.feed = operating[0], .heat = operating[1]});
  if (!system.ok()) return Of("operating_inputs", system.status());
  MLE_ASSIGN_OR_RETURN(
      sim::ContinuousPlant plant,
      sim::ContinuousPlant::Create(*std::move(system),
                                   {.sample_time = FLAGS_sample_time}));
  return std::make_unique<sim::ContinuousPlant>(std::move(plant));
}

absl::StatusOr<std::unique_ptr<sim::PlantModel>> MakePlant(
    const ProcessModel& model) {
  if (FLAGS_plant == kReactor) return MakeReactor(model);
  ProcessModel plant = model;
  if (!FLAGS_plant.empty()) {
    MLE_ASSIGN_OR_RETURN(plant, ReadModelOf("plant", FLAGS_plant));
    MLE_RETURN_IF_ERROR(
        CheckSameChannels(model, FLAGS_model, plant, FLAGS_plant));
  }
  sim::AgeingSchedule ageing;
  if (!FLAGS_ageing.empty()) {
    absl::StatusOr<sim::AgeingSchedule> read =
        sim::ReadAgeingSchedule(FLAGS_ageing, plant);
    if (!read.ok()) return Of("ageing", read.status());
    ageing = *std::move(read);
  }
  MLE_ASSIGN_OR_RETURN(
      sim::AgeingPlant ageing_plant,
      sim::AgeingPlant::Create(
          plant, ageing,
          {.sample_time = FLAGS_sample_time, .start_time = FLAGS_age}));
  return std::make_unique<sim::AgeingPlant>(std::move(ageing_plant));
}

absl::StatusOr<control::MpcLimits> LimitsFromFlags(int outputs, int inputs) {
  control::MpcLimits limits;
  MLE_ASSIGN_OR_RETURN(
      limits.min_input,
      ParseLimits("min_input", FLAGS_min_input, inputs, -kInfinity));
  MLE_ASSIGN_OR_RETURN(
      limits.max_input,
      ParseLimits("max_input", FLAGS_max_input, inputs, kInfinity));
  MLE_ASSIGN_OR_RETURN(limits.max_move, ParseLimits("max_move", FLAGS_max_move,
                                                    inputs, kInfinity));
  MLE_ASSIGN_OR_RETURN(
      limits.min_output,
      ParseLimits("min_output", FLAGS_min_output, outputs, -kInfinity));
  MLE_ASSIGN_OR_RETURN(
      limits.max_output,
      ParseLimits("max_output", FLAGS_max_output, outputs, kInfinity));
  if (limits.min_output.size() != 0 || limits.max_output.size() != 0) {
    MLE_ASSIGN_OR_RETURN(
        limits.output_limit_cost,
        ParseNumbers("output_limit_cost", FLAGS_output_limit_cost, outputs));
  }
  return limits;
}

absl::StatusOr<sim::MeasurementFaultOptions> FaultsFromFlags(int outputs) {
  sim::MeasurementFaultOptions faults;
  faults.outlier_probability = FLAGS_outlier_probability;
  MLE_ASSIGN_OR_RETURN(
      faults.outlier_size,
      ParseNumbers("outlier_size", FLAGS_outlier_size, outputs));
  MLE_ASSIGN_OR_RETURN(faults.quantum,
                       ParseNumbers("quantum", FLAGS_quantum, outputs));
  faults.freeze_rate = FLAGS_freeze_rate;
  faults.freeze_duration = FLAGS_freeze_duration;
  faults.lost_probability = FLAGS_lost_probability;
  faults.lost_input_probability = FLAGS_lost_input_probability;
  faults.only_in_record = FLAGS_faults_only_in_record;
  return faults;
}

absl::StatusOr<sim::PlantConditions> ConditionsFromFlags(
    const ProcessModel& model) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  sim::PlantConditions conditions;
  sim::OutputDisturbanceOptions& outputs = conditions.output_disturbance;
  MLE_ASSIGN_OR_RETURN(
      outputs.coloured_variance,
      ParseNumbers("coloured_variance", FLAGS_coloured_variance, p));
  outputs.coloured_time_constant = FLAGS_coloured_time_constant;
  MLE_ASSIGN_OR_RETURN(outputs.drift_variance,
                       ParseNumbers("drift_variance", FLAGS_drift_variance, p));
  outputs.step_rate = FLAGS_disturbance_step_rate;
  MLE_ASSIGN_OR_RETURN(outputs.step_deviation,
                       ParseNumbers("disturbance_step_deviation",
                                    FLAGS_disturbance_step_deviation, p));

  sim::InputDisturbanceOptions& inputs = conditions.input_disturbance;
  MLE_ASSIGN_OR_RETURN(const std::vector<NamedStep> steps,
                       ParseNamedSteps("disturbances", FLAGS_disturbances,
                                       NamesOf(model.inputs())));
  for (const NamedStep& step : steps) {
    inputs.steps.push_back({step.channel, step.time, step.value});
  }
  MLE_ASSIGN_OR_RETURN(
      inputs.variance,
      ParseNumbers("disturbance_variance", FLAGS_disturbance_variance, m));
  inputs.time_constant = FLAGS_disturbance_time_constant;

  MLE_ASSIGN_OR_RETURN(
      conditions.valves.min,
      ParseLimits("valve_min", FLAGS_valve_min, m, -kInfinity));
  MLE_ASSIGN_OR_RETURN(conditions.valves.max,
                       ParseLimits("valve_max", FLAGS_valve_max, m, kInfinity));
  MLE_ASSIGN_OR_RETURN(conditions.faults, FaultsFromFlags(p));
  MLE_RETURN_IF_ERROR(conditions.Validate(model));
  return conditions;
}

absl::StatusOr<sim::SetPointProfile> SetPointsFromFlags(
    const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(
      const std::vector<NamedStep> steps,
      ParseNamedSteps("setpoints", FLAGS_setpoints, NamesOf(model.outputs())));
  sim::SetPointProfile set_points;
  for (const NamedStep& step : steps) {
    if (step.time > FLAGS_duration) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--setpoints: a step of '", model.outputs()[step.channel].name,
          "' at ", step.time,
          " comes after the end of the run, --duration=", FLAGS_duration));
    }
    set_points.steps.push_back({step.channel, step.time, step.value});
  }
  return set_points;
}

}  // namespace

absl::StatusOr<Simulation> SimulationFromFlags() {
  if (FLAGS_model.empty() || FLAGS_out.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE.json and --out=FILE.csv must be given (see --help)");
  }
  Simulation simulation;
  MLE_ASSIGN_OR_RETURN(simulation.model, ReadModelOf("model", FLAGS_model));
  const ProcessModel& model = simulation.model;
  sim::ClosedLoopOptions& loop = simulation.loop;
  loop.sample_time = FLAGS_sample_time;
  loop.control_period = FLAGS_control_period;
  loop.duration = FLAGS_duration;
  loop.noise_variance = FLAGS_noise_variance;
  loop.seed = FLAGS_seed;
  MLE_RETURN_IF_ERROR(loop.Validate());
  MLE_ASSIGN_OR_RETURN(simulation.plant, MakePlant(model));
  MLE_ASSIGN_OR_RETURN(simulation.controller, ControllerFromFlags(model));
  MLE_ASSIGN_OR_RETURN(
      simulation.controller.limits,
      LimitsFromFlags(model.num_outputs(), model.num_inputs()));
  simulation.feed_forward = FLAGS_feed_forward;
  simulation.preview = FLAGS_preview;
  MLE_ASSIGN_OR_RETURN(simulation.set_points, SetPointsFromFlags(model));
  MLE_ASSIGN_OR_RETURN(simulation.conditions, ConditionsFromFlags(model));
  return simulation;
}

std::string OutFromFlags() { return FLAGS_out; }

}  // namespace mle::simulate
