#include "apps/simulate/request.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/model_files.h"
#include "apps/common/shared_options.h"
#include "apps/simulate/nonlinear_plants.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "sim/ageing_json.h"
#include "sim/ageing_plant.h"
#include "sim/continuous_plant.h"
#include "sim/effects_json.h"
#include "sim/transformed_plant.h"

namespace mle::simulate {
namespace {

// The options of mle_simulate for what a plant has to bear.

std::vector<Option> OptionsOf(sim::OutputDisturbanceOptions& options) {
  return {
      {"coloured_variance", ForEachOutput(&options.coloured_variance, "0"),
       "Variance of a coloured disturbance of the outputs: one value, or one "
       "for each output.",
       "", kNotNegative},
      {"coloured_time_constant", &options.coloured_time_constant,
       "Correlation time of the coloured disturbance.", "min", kPositive},
      {"drift_variance", ForEachOutput(&options.drift_variance, "0"),
       "Variance q of the increments per sample of a random-walk disturbance "
       "of the outputs: one value, or one for each output.",
       "", kNotNegative},
      {"disturbance_step_rate", &options.step_rate,
       "Mean number of step disturbances of an output per unit of time.",
       "1/min", kNotNegative},
      {"disturbance_step_deviation",
       ForEachOutput(&options.step_deviation, "0"),
       "Standard deviation of a step disturbance: one value, or one for each "
       "output.",
       "", kNotNegative},
  };
}

// But for their steps, which name inputs.
std::vector<Option> OptionsOf(sim::InputDisturbanceOptions& options) {
  return {
      {"disturbance_variance", ForEachInput(&options.variance, "0"),
       "Variance of coloured noise on the inputs with the role of "
       "disturbances: one value, or one for each input of the model.",
       "", kNotNegative},
      {"disturbance_time_constant", &options.time_constant,
       "Correlation time of that noise on the inputs.", "min", kPositive},
  };
}

std::vector<Option> OptionsOf(sim::ValveLimits& limits) {
  return {
      {"valve_min", LimitOfEachInput(&limits.min, -kInfinity),
       "Lower limits of the plant's valves, which the controller does not "
       "know; as --min_input."},
      {"valve_max", LimitOfEachInput(&limits.max, kInfinity),
       "Upper limits of the plant's valves, as --valve_min."},
  };
}

std::vector<Option> OptionsOf(sim::MeasurementFaultOptions& options) {
  return {
      {"outlier_probability", &options.outlier_probability,
       "Probability that a measured sample of an output is an outlier.", "",
       kShare},
      {"outlier_size", ForEachOutput(&options.outlier_size, "0"),
       "Largest outlier; the size of an outlier is uniform between a fifth of "
       "this value and this value. One value, or one for each output.",
       "", kNotNegative},
      {"quantum", ForEachOutput(&options.quantum, "0"),
       "Quantum of the measured outputs; 0: no rounding. One value, or one for "
       "each output.",
       "", kNotNegative},
      {"freeze_rate", &options.freeze_rate,
       "Mean number of times a measured output freezes per unit of time.",
       "1/min", kNotNegative},
      {"freeze_duration", &options.freeze_duration,
       "Mean duration for which a measured output is frozen.", "min",
       kPositive},
      {"lost_probability", &options.lost_probability,
       "Probability that a sample of an output is lost.", "", kShare},
      {"lost_input_probability", &options.lost_input_probability,
       "Probability that a sample of an input is lost in the record.", "",
       kShare},
      {"faults_only_in_record", &options.only_in_record,
       "Outliers, rounding, frozen and lost samples occur in the historian; "
       "the controller receives the measurements without these faults."},
  };
}

// "feed (1/h) and heat (kJ/h)"
std::string InputsOf(const NonlinearPlant& plant) {
  return absl::StrJoin(plant.channels.inputs(), " and ",
                       [](std::string* out, const InputChannel& input) {
                         absl::StrAppend(out, input.name, " (", input.unit,
                                         ")");
                       });
}

// One phrase of each non-linear plant.
template <typename Phrase>
std::string OfNonlinearPlants(const Phrase& phrase) {
  return absl::StrJoin(NonlinearPlants(), "; ",
                       [&](std::string* out, const NonlinearPlant& plant) {
                         absl::StrAppend(out, phrase(plant));
                       });
}

std::vector<Option> PlantOptions(Request& request) {
  return {
      {"model", &request.model_path, "Process model (JSON) of the controller."},
      {"plant", &request.plant,
       absl::StrCat(
           "The plant: a process model (JSON) with the same inputs and "
           "outputs, or a non-linear one: ",
           OfNonlinearPlants([](const NonlinearPlant& plant) {
             return absl::StrCat(plant.name, " (", plant.about, ", time in ",
                                 plant.channels.time_unit(), ")");
           }),
           ". Empty: --model.")},
      {"operating_inputs", Numbers(&request.operating_inputs),
       absl::StrCat(
           "Inputs of the steady state at which a non-linear plant starts; the "
           "record has deviations from that state. ",
           OfNonlinearPlants([](const NonlinearPlant& plant) {
             return absl::StrCat(plant.name, ": ", InputsOf(plant), ", ",
                                 absl::StrJoin(plant.operating_inputs, ","),
                                 " if empty");
           }),
           ".")},
      {"ageing", &request.ageing_path,
       "Ageing schedule (JSON) of the plant's elements: gains, time constants "
       "and dead times over time; of a non-linear plant factors of its own."},
      {"age", &request.age, "Time of --ageing at which the run begins.", "min"},
  };
}

std::vector<Option> RunOptions(Request& request) {
  sim::ClosedLoopOptions& loop = request.simulation.loop;
  return {
      {"setpoints", &request.set_points,
       "NAME:TIME:VALUE,… set points of outputs: VALUE from TIME on, 0 before "
       "the first change."},
      {"duration", &loop.duration, "Length of the run.", "min", kPositive},
      {"sample_time", &loop.sample_time, "Sample time Δt of the record.", "min",
       kPositive},
      {"noise_variance", &loop.noise_variance,
       "Variance σ² of the white measurement noise of every output.", "",
       kNotNegative},
      {"seed", &loop.seed, "Seed of all random numbers."},
      {"out", &request.out, "The record to be written (CSV). Must be given."},
  };
}

absl::StatusOr<std::unique_ptr<sim::PlantModel>> MakeNonlinear(
    const NonlinearPlant& made, const Request& request) {
  MLE_RETURN_IF_ERROR(CheckSameChannels(
      request.simulation.model, request.model_path, made.channels, made.name));
  std::vector<double> inputs = request.operating_inputs;
  if (inputs.empty()) inputs = made.operating_inputs;
  if (inputs.size() != made.operating_inputs.size()) {
    return RefuseOption("operating_inputs", absl::StrJoin(inputs, ","),
                        absl::StrCat(InputsOf(made), " are needed"));
  }
  MLE_ASSIGN_OR_RETURN(sim::ContinuousSystem system,
                       made.make(inputs, request.ageing_path, request.age));
  MLE_ASSIGN_OR_RETURN(sim::ContinuousPlant plant,
                       sim::ContinuousPlant::Create(
                           std::move(system),
                           {.sample_time = request.simulation.loop.sample_time,
                            .start_time = request.age}));
  return std::make_unique<sim::ContinuousPlant>(std::move(plant));
}

// Where a channel is at rest: at the operating point of its transform in the
// plant or, if it has none there, in the controller's model; 0 without one.
template <typename Channel>
Eigen::VectorXd OperatingPoint(const std::vector<Channel>& of_plant,
                               const std::vector<Channel>& of_model) {
  Eigen::VectorXd at =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(of_plant.size()));
  for (std::size_t i = 0; i < of_plant.size(); ++i) {
    const Transform& transform = of_plant[i].transform;
    at[static_cast<Eigen::Index>(i)] =
        transform.IsNone() ? of_model[i].transform.at : transform.at;
  }
  return at;
}

absl::StatusOr<std::unique_ptr<sim::PlantModel>> MakePlant(Request& request) {
  ProcessModel plant = request.simulation.model;
  Simulation& simulation = request.simulation;
  simulation.operating_inputs = OperatingPoint(plant.inputs(), plant.inputs());
  simulation.operating_outputs =
      OperatingPoint(plant.outputs(), plant.outputs());
  if (const NonlinearPlant* named = FindNonlinearPlant(request.plant)) {
    return MakeNonlinear(*named, request);
  }
  if (request.plant_model.has_value()) {
    MLE_RETURN_IF_ERROR(
        CheckSameChannels(plant, "model", *request.plant_model, "plant"));
    plant = *request.plant_model;
  } else if (!request.plant.empty()) {
    MLE_ASSIGN_OR_RETURN(
        plant, ReadModelLike(request.simulation.model, request.model_path,
                             "plant", request.plant));
  }
  sim::AgeingSchedule ageing;
  if (!request.ageing_path.empty()) {
    MLE_ASSIGN_OR_RETURN(
        ageing, AboutOption("ageing", sim::ReadAgeingSchedule(
                                          request.ageing_path, plant)));
  }
  MLE_ASSIGN_OR_RETURN(sim::AgeingPlant ageing_plant,
                       sim::AgeingPlant::Create(
                           plant, ageing,
                           {.sample_time = request.simulation.loop.sample_time,
                            .start_time = request.age}));
  auto linear = std::make_unique<sim::AgeingPlant>(std::move(ageing_plant));
  if (!HasTransforms(plant)) return linear;
  simulation.operating_inputs =
      OperatingPoint(plant.inputs(), simulation.model.inputs());
  simulation.operating_outputs =
      OperatingPoint(plant.outputs(), simulation.model.outputs());
  return std::make_unique<sim::TransformedPlant>(std::move(linear), plant);
}

absl::Status ReadSteps(const Request& request, Simulation& simulation) {
  const ProcessModel& model = simulation.model;
  MLE_ASSIGN_OR_RETURN(const std::vector<NamedStep> set_points,
                       ParseNamedSteps("setpoints", request.set_points,
                                       NamesOf(model.outputs())));
  for (const NamedStep& step : set_points) {
    if (!(step.time <= simulation.loop.duration)) {
      return InvalidArgument(
          "--setpoints: a step of '", model.outputs()[step.channel].name,
          "' at ", step.time, " comes after the end of the run, --duration=",
          simulation.loop.duration);
    }
    simulation.set_points.steps.push_back(
        {step.channel, step.time, step.value});
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<NamedStep> disturbances,
                       ParseNamedSteps("disturbances", request.disturbances,
                                       NamesOf(model.inputs())));
  for (const NamedStep& step : disturbances) {
    simulation.conditions.input_disturbance.steps.push_back(
        {step.channel, step.time, step.value});
  }
  return absl::OkStatus();
}

absl::Status ReadEffects(const Request& request, Simulation& simulation) {
  if (request.effects_path.empty()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(
      const sim::Effects effects,
      AboutOption("effects",
                  sim::ReadEffects(request.effects_path, simulation.model)));
  effects.AddTo(simulation.conditions);
  const sim::ClosedLoopOptions& loop = simulation.loop;
  return AboutOption(
      "effects", effects.AddTo(simulation.set_points, loop.duration, loop.seed,
                               loop.stream));
}

}  // namespace

void AddOptions(Request& request, OptionTable& table) {
  Simulation& simulation = request.simulation;
  sim::PlantConditions& conditions = simulation.conditions;
  table.Add("Model and plant", PlantOptions(request));
  table.Add("Run", RunOptions(request));
  table.Add("Run",
            {{"effects", &request.effects_path,
              "Effects (JSON) of the plant and its historian, channel by "
              "channel: disturbances, loads, sticking valves, sensors, ramps "
              "and moves of set points, compression of the archive."}});
  table.Add("Controller", mle::OptionsOf(simulation.controller));
  table.Add("Controller",
            {{"feed_forward", &simulation.feed_forward,
              "The controller uses measurements of the inputs with the role of "
              "disturbances."},
             {"preview", &simulation.preview,
              "The controller knows future set points."}});
  table.Add("Limits in the controller",
            mle::OptionsOf(simulation.controller.limits));
  table.Add("Disturbances of the outputs",
            OptionsOf(conditions.output_disturbance));
  table.Add("Measured disturbances",
            {{"disturbances", &request.disturbances,
              "NAME:TIME:VALUE,… steps of inputs with the role of "
              "disturbances: VALUE from TIME on, 0 before the first step."}});
  table.Add("Measured disturbances", OptionsOf(conditions.input_disturbance));
  table.Add("Valves", OptionsOf(conditions.valves));
  table.Add("Faults of measurements", OptionsOf(conditions.faults));
  table.PutFirst({"model", "plant", "setpoints", "duration", "sample_time",
                  "noise_variance", "drift_variance", "control_period", "seed",
                  "out", "effects"});
}

absl::Status Complete(Request& request, OptionTable& table) {
  if (request.model_path.empty() || request.out.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE.json and --out=FILE.csv must be given (see --help)");
  }
  MLE_ASSIGN_OR_RETURN(request.simulation.model,
                       ReadModel("model", request.model_path));
  return CompleteForModel(request, table);
}

absl::Status CompleteForModel(Request& request, OptionTable& table) {
  Simulation& simulation = request.simulation;
  simulation.loop.control_period = simulation.controller.control_period;
  MLE_RETURN_IF_ERROR(simulation.loop.Validate());
  MLE_ASSIGN_OR_RETURN(simulation.plant, MakePlant(request));
  MLE_RETURN_IF_ERROR(table.FitTo(simulation.model));
  control::MpcLimits& limits = simulation.controller.limits;
  if (limits.min_output.size() == 0 && limits.max_output.size() == 0) {
    limits.output_limit_cost.resize(0);
  }
  MLE_RETURN_IF_ERROR(ReadSteps(request, simulation));
  MLE_RETURN_IF_ERROR(ReadEffects(request, simulation));
  return simulation.conditions.Validate(simulation.model);
}

}  // namespace mle::simulate
