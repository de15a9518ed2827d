#include "sim/closed_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/data/sampling.h"
#include "sim/plant.h"
#include "sim/runaway.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

int SamplesPerControlPeriod(const ClosedLoopOptions& options) {
  return static_cast<int>(
      std::round(options.control_period / options.sample_time));
}

absl::Status CheckSizes(const PlantModel& plant, const ProcessModel& channels) {
  if (plant.num_inputs() == channels.num_inputs() &&
      plant.num_outputs() == channels.num_outputs()) {
    return absl::OkStatus();
  }
  return InvalidArgument("the plant has ", plant.num_inputs(), " inputs and ",
                         plant.num_outputs(), " outputs, its process model ",
                         channels.num_inputs(), " and ", channels.num_outputs(),
                         "; they must be the same");
}

// All that is drawn or known before the run.
struct Surroundings {
  MatrixXd set_points;           // p × N
  MatrixXd output_disturbances;  // p × N, with the measurement noise
  MatrixXd input_disturbances;   // m × N
  MatrixXd loads;                // m × N
  VectorXd output_sizes;         // p, of what is to be expected
};

// The sizes (p) of what set points, disturbances and loads do to the outputs.
VectorXd ExpectedSizes(const Surroundings& all, const ProcessModel& channels) {
  const auto largest = [](const MatrixXd& signals) -> VectorXd {
    return signals.cwiseAbs().rowwise().maxCoeff();
  };
  VectorXd sizes =
      largest(all.set_points).cwiseMax(largest(all.output_disturbances));
  const VectorXd inputs =
      largest(all.input_disturbances).cwiseMax(largest(all.loads));
  for (const auto& [i, j] : Pairs(channels)) {
    sizes[i] = std::max(
        sizes[i], std::abs(channels.element(i, j).StaticGain()) * inputs[j]);
  }
  return sizes;
}

Surroundings MakeSurroundings(const ProcessModel& channels,
                              const SetPointProfile& set_points,
                              const ClosedLoopOptions& options,
                              const PlantConditions& conditions) {
  const int p = channels.num_outputs();
  const int samples = SampleCount(options.sample_time, options.duration);
  const double noise_deviation = std::sqrt(options.noise_variance);
  Surroundings all;
  all.set_points = set_points.Sample(p, options.sample_time, samples);
  all.output_disturbances = DrawOutputDisturbance(
      conditions.output_disturbance, p, options.sample_time, samples,
      options.seed, options.stream);
  all.input_disturbances = DrawInputDisturbances(
      conditions.input_disturbance, channels, options.sample_time, samples,
      options.seed, options.stream);
  all.loads = DrawInputLoads(conditions.loads, channels.num_inputs(),
                             options.sample_time, samples, options.seed,
                             options.stream);

  all.output_sizes = ExpectedSizes(all, channels).cwiseMax(noise_deviation);

  Sensors(conditions.sensors, options.sample_time)
      .FollowAll(all.output_disturbances);
  all.output_disturbances += GaussianNoise(options.seed, options.stream)
                                 .DrawMatrix(p, samples, noise_deviation);
  for (const SensorOptions& sensor : conditions.sensors) {
    GaussianNoise noise(options.seed, options.stream,
                        kSensorNoise + sensor.output);
    all.output_disturbances.row(sensor.output) +=
        noise.DrawMatrix(1, samples, std::sqrt(sensor.noise_variance));
  }
  return all;
}

std::vector<int> DisturbanceInputs(const ProcessModel& channels) {
  std::vector<int> inputs;
  for (int j = 0; j < channels.num_inputs(); ++j) {
    if (channels.inputs()[j].role == InputRole::kDisturbance) {
      inputs.push_back(j);
    }
  }
  return inputs;
}

// The sensors and their faults, between the plant and those who watch it.
class Instruments {
 public:
  Instruments(const PlantConditions& conditions,
              const ClosedLoopOptions& options, int p, int m, int samples)
      : only_in_record_(conditions.faults.only_in_record),
        sensors_(conditions.sensors, options.sample_time),
        faults_(conditions.faults, p, m, options.sample_time, samples,
                options.seed, options.stream),
        seen_(VectorXd::Zero(p)) {}

  // Adds the plant's outputs at sample k to their disturbances, `recorded`, and
  // makes of them what the record holds.
  void Measure(int k, double time, const VectorXd& plant_outputs,
               Eigen::Ref<VectorXd> recorded) {
    VectorXd outputs = plant_outputs;
    sensors_.Follow(outputs);
    recorded += outputs;
    if (only_in_record_) seen_ = recorded;
    sensors_.Show(time, recorded);
    faults_.SpoilOutputs(k, recorded);
    if (only_in_record_) return;
    for (Eigen::Index i = 0; i < recorded.size(); ++i) {
      if (!std::isnan(recorded[i])) seen_[i] = recorded[i];
    }
  }

  // The outputs (p) that the controller sees.
  const VectorXd& seen() const { return seen_; }

  void SpoilInputs(int k, Eigen::Ref<VectorXd> inputs) const {
    faults_.SpoilInputs(k, inputs);
  }

 private:
  bool only_in_record_;
  Sensors sensors_;
  MeasurementFaults faults_;
  VectorXd seen_;
};

// The actuators, which make of the inputs asked for those that act on the
// plant.
class Actuators {
 public:
  Actuators(const std::vector<ActuatorOptions>& options, double sample_time,
            int m)
      : actuators_(options.begin(), options.end()),
        sample_time_(sample_time),
        acting_(VectorXd::Zero(m)) {}

  void Move(const VectorXd& inputs) {
    for (Actuator& actuator : actuators_)
      actuator.Move(inputs[actuator.input()]);
  }

  const VectorXd& Acting(const VectorXd& inputs,
                         const Eigen::Ref<const VectorXd>& loads) {
    acting_ = inputs;
    for (Actuator& actuator : actuators_) {
      acting_[actuator.input()] = actuator.Act(sample_time_);
    }
    acting_ += loads;
    return acting_;
  }

 private:
  std::vector<Actuator> actuators_;
  double sample_time_;
  VectorXd acting_;  // m
};

// The changes that operators and others make to the inputs that the controller
// asks for.
class Operators {
 public:
  Operators(const PlantConditions& conditions, int m)
      : manual_(conditions.manual), answered_(VectorXd::Zero(m)) {
    for (const InputLoad& load : conditions.loads) {
      answered_[load.input] = load.answered;
    }
  }

  // The inputs from a control instant on, in place of those of before, of what
  // the controller asked for.
  void Move(double time, const VectorXd& asked, const VectorXd& loads,
            VectorXd& inputs) {
    const VectorXd before = inputs;
    inputs = asked - answered_.cwiseProduct(loads);
    is_manual_ = false;
    for (const ManualPeriod& period : manual_) {
      if (time < period.from || time >= period.to) continue;
      is_manual_ = true;
      const bool has_begun = before_ >= period.from;
      inputs[period.input] =
          before[period.input] + (has_begun ? 0.0 : period.change);
    }
    before_ = time;
  }

  // Whether the controller has nothing to say.
  bool is_manual() const { return is_manual_; }

 private:
  std::vector<ManualPeriod> manual_;
  VectorXd answered_;  // m
  double before_ = -std::numeric_limits<double>::infinity();
  bool is_manual_ = false;
};

}  // namespace

absl::Status ClosedLoopOptions::Validate() const {
  MLE_RETURN_IF_ERROR(ValidateSampling(sample_time, duration));
  const double ratio = control_period / sample_time;
  if (!(ratio >= 1.0 - 1e-9) || ratio > 1e9 ||
      std::abs(ratio - std::round(ratio)) > 1e-9 * ratio) {
    return InvalidArgument(
        "control_period = ", control_period,
        ", but it must be a whole multiple of sample_time = ", sample_time);
  }
  return ValidateNoiseVariance(noise_variance);
}

absl::StatusOr<Record> SimulateClosedLoop(PlantModel& plant,
                                          const ProcessModel& channels,
                                          const Controller& controller,
                                          const SetPointProfile& set_points,
                                          const ClosedLoopOptions& options,
                                          const PlantConditions& conditions) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(channels.Validate());
  MLE_RETURN_IF_ERROR(CheckSizes(plant, channels));
  MLE_RETURN_IF_ERROR(conditions.Validate(channels));
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  MLE_RETURN_IF_ERROR(set_points.Validate(p));

  Surroundings all =
      MakeSurroundings(channels, set_points, options, conditions);
  const int samples = static_cast<int>(all.set_points.cols());
  const int samples_per_period = SamplesPerControlPeriod(options);
  const RunawayGuard guard(channels, all.output_sizes);
  const std::vector<int> disturbances = DisturbanceInputs(channels);
  Instruments instruments(conditions, options, p, m, samples);
  Actuators actuators(conditions.actuators, options.sample_time, m);
  Operators operators(conditions, m);
  Record record;
  record.sample_time = options.sample_time;
  record.set_points = std::move(all.set_points);
  record.outputs = std::move(all.output_disturbances);
  record.inputs.resize(m, samples);

  VectorXd input = VectorXd::Zero(m);
  VectorXd next_input = VectorXd::Zero(m);
  for (int k = 0; k < samples; ++k) {
    MLE_RETURN_IF_ERROR(guard.CheckOutputs(plant.outputs(), record.time(k)));
    instruments.Measure(k, record.time(k), plant.outputs(),
                        record.outputs.col(k));
    const bool is_control_instant = k % samples_per_period == 0;
    if (is_control_instant) {
      operators.Move(record.time(k), next_input, all.loads.col(k), input);
      for (int j = 0; j < m; ++j) {
        input[j] = conditions.valves.Limit(j, input[j]);
      }
      actuators.Move(input);
    }
    for (const int j : disturbances) {
      input[j] = next_input[j] = all.input_disturbances(j, k);
    }
    if (is_control_instant) {
      MLE_RETURN_IF_ERROR(guard.CheckInputs(input, record.time(k)));
      controller(instruments.seen(),
                 operators.is_manual() ? instruments.seen()
                                       : record.set_points.col(k).eval(),
                 next_input);
    }
    record.inputs.col(k) = input;
    instruments.SpoilInputs(k, record.inputs.col(k));
    plant.Advance(actuators.Acting(input, all.loads.col(k)));
  }
  ExportFromArchive(conditions.archive, record);
  return record;
}

absl::StatusOr<Record> SimulateClosedLoop(const ProcessModel& plant_model,
                                          const Controller& controller,
                                          const SetPointProfile& set_points,
                                          const ClosedLoopOptions& options,
                                          const PlantConditions& conditions) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (HasTransforms(plant_model)) {
    return absl::InvalidArgumentError(
        "a channel of the plant has a transform, which only mle_simulate "
        "simulates");
  }
  MLE_ASSIGN_OR_RETURN(
      Plant plant,
      Plant::Create(plant_model, {.sample_time = options.sample_time}));
  return SimulateClosedLoop(plant, plant_model, controller, set_points, options,
                            conditions);
}

}  // namespace mle::sim
