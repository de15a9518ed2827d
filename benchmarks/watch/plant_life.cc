#include "benchmarks/watch/plant_life.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "glog/logging.h"
#include "mle/base/random.h"
#include "mle/model/element_response.h"
#include "sim/closed_loop.h"
#include "sim/plant_conditions.h"

namespace mle::benchmarks {
namespace {

constexpr double kMinute = 1.0;
constexpr int kMinutesOfDay = 1440;
constexpr double kNoiseVariance = 1e-3;
constexpr int kOutputs = 2;

sim::PlantConditions ConditionsOf(Effect effect) {
  using Eigen::VectorXd;
  sim::PlantConditions conditions;
  const bool both = effect == Effect::kHeavyTails;
  if (effect == Effect::kDrift) {
    conditions.output_disturbance.drift_variance =
        VectorXd::Constant(kOutputs, 1e-5);
  }
  if (effect == Effect::kColoured || both) {
    conditions.output_disturbance.coloured_variance =
        VectorXd::Constant(kOutputs, 0.01);
  }
  if (effect == Effect::kInputLoad) {
    for (int j = 0; j < 2; ++j) {
      conditions.loads.push_back(
          {.input = j, .variance = 1e-4, .time_constant = 200.0});
    }
  }
  if (effect == Effect::kSine) {
    for (int i = 0; i < kOutputs; ++i) {
      conditions.output_disturbance.sines.push_back(
          {.output = i, .amplitude = 0.1, .period = 20.0});
    }
  }
  if (effect == Effect::kOutliers || both) {
    conditions.faults.outlier_probability = 0.002;
    conditions.faults.outlier_size = VectorXd::Constant(kOutputs, 1.0);
    conditions.faults.only_in_record = true;
  }
  if (both) conditions.faults.lost_probability = 0.01;
  if (effect == Effect::kCompression) {
    for (int i = 0; i < kOutputs; ++i) {
      conditions.archive.outputs.push_back(
          {.channel = i, .compression = 2.0 * std::sqrt(kNoiseVariance)});
    }
  }
  if (effect == Effect::kSteps) {
    conditions.output_disturbance.step_deviation =
        VectorXd::Constant(kOutputs, 0.1);
    conditions.output_disturbance.step_rate = 1.0 / 800.0;
  }
  if (effect == Effect::kStiction) {
    for (int j = 0; j < 2; ++j) {
      conditions.actuators.push_back(
          {.input = j, .stiction = 0.005, .slip_jump = 0.0025});
    }
  }
  if (effect == Effect::kSaturation) {
    conditions.valves.min = VectorXd::Constant(2, -0.1);
    conditions.valves.max = VectorXd::Constant(2, 0.1);
  }
  return conditions;
}

control::Mpc MakeController(const ProcessModel& model) {
  control::MpcOptions options;
  options.control_period = kMinute;
  options.output_weight = 0.2 * Eigen::MatrixXd::Identity(kOutputs, kOutputs);
  options.move_weight = 0.1 * Eigen::MatrixXd::Identity(2, 2);
  absl::StatusOr<control::Mpc> mpc = control::Mpc::Create(model, options);
  CHECK(mpc.ok()) << mpc.status();
  return *std::move(mpc);
}

int DrawWhole(int below, std::mt19937_64& engine) {
  return static_cast<int>(below * DrawUniform(engine));
}

}  // namespace

std::string NameOf(Effect effect) {
  switch (effect) {
    case Effect::kWhiteNoise:
      return "white";
    case Effect::kDrift:
      return "drift";
    case Effect::kColoured:
      return "coloured";
    case Effect::kInputLoad:
      return "load";
    case Effect::kSine:
      return "sine";
    case Effect::kOutliers:
      return "outliers";
    case Effect::kCompression:
      return "compression";
    case Effect::kHeavyTails:
      return "heavy_tails";
    case Effect::kSteps:
      return "steps";
    case Effect::kStiction:
      return "stiction";
    case Effect::kSaturation:
      return "saturation";
    case Effect::kNoisier:
      return "noisier";
  }
  return "";
}

std::string NameOf(Ageing ageing) {
  switch (ageing) {
    case Ageing::kNone:
      return "none";
    case Ageing::kGain:
      return "gain";
    case Ageing::kDelay:
      return "delay";
    case Ageing::kTimeConstant:
      return "time_constant";
  }
  return "";
}

PlantLife::PlantLife(const ProcessModel& model, const LifeOptions& options)
    : model_(model), options_(options), controller_(MakeController(model)) {
  std::mt19937_64 engine =
      SeededEngine(options.seed, kAgeingStream, kSetPointTimes);
  ageing_.output = DrawWhole(kOutputs, engine);
  ageing_.input = DrawWhole(2, engine);
  ageing_.begin = 60 + DrawWhole(120, engine);
  for (int day = 0; day < options.days; ++day) {
    moves_.push_back(DrawUniform(engine) < options.changes_per_day);
  }
}

ProcessModel PlantLife::PlantAfter(Ageing ageing, const AgeingElement& element,
                                   int days) const {
  ProcessModel plant = model_;
  if (ageing == Ageing::kNone || days < 0) return plant;
  TransferFunction& aged = plant.element(element.output, element.input);
  const absl::StatusOr<ElementResponse> response =
      ElementResponse::Create(aged);
  CHECK(response.ok()) << response.status();
  ElementValues values = response->initial_values();
  if (ageing == Ageing::kGain) {
    values.gain *= 1.0 - 0.3 * std::min(days / 365.0, 1.0);
  } else if (ageing == Ageing::kDelay) {
    values.delay *= 1.5;
  } else {
    values.time_scale *= 1.5;
  }
  aged = response->ToTransferFunction(values);
  return plant;
}

WatchBatch PlantLife::Day(int day, int lead) const {
  const auto stream = static_cast<std::uint64_t>(day) + 1;
  std::mt19937_64 engine = SeededEngine(options_.seed, stream, kSetPointSizes);
  sim::SetPointProfile profile;
  if (moves_[day]) {
    const int output = DrawWhole(kOutputs, engine);
    const double size = (0.5 + 0.5 * DrawUniform(engine)) *
                        (DrawUniform(engine) < 0.5 ? -1.0 : 1.0);
    const double time = lead + 60.0 + DrawWhole(400, engine);
    profile.steps = {{output, time, size},
                     {output, time + 400.0 + DrawWhole(200, engine), 0.0}};
  }
  control::Mpc mpc = controller_;
  sim::ClosedLoopOptions loop;
  loop.sample_time = kMinute;
  loop.control_period = kMinute;
  loop.duration = (lead + kMinutesOfDay - 1) * kMinute;
  loop.noise_variance = kNoiseVariance;
  if (options_.effect == Effect::kNoisier) {
    loop.noise_variance *= 1.0 + 3.0 * DrawUniform(engine);
  }
  loop.seed = options_.seed;
  loop.stream = stream;
  absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      PlantAfter(options_.ageing, ageing_, day - ageing_.begin),
      [&mpc](const auto& measured, const auto& wanted, auto next) {
        mpc.Step(measured, wanted, next);
      },
      profile, loop, ConditionsOf(options_.effect));
  CHECK(record.ok()) << record.status();
  return {.record = *std::move(record), .first = lead};
}

}  // namespace mle::benchmarks
