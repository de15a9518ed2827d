#include "benchmarks/trial/trial_life.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/LU"
#include "control/mpc.h"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/base/random.h"
#include "mle/maintain/correct.h"
#include "mle/model/element_response.h"
#include "sim/closed_loop.h"

namespace mle::benchmarks {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDaySettlings = 6.0;
// At rest before the set points of the first record move.
constexpr double kQuietSettlings = 15.0;

class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t stream)
      : engine_(SeededEngine(seed, stream, kSetPointTimes)) {}
  double Uniform(double low, double high) {
    return low + (high - low) * DrawUniform(engine_);
  }
  // Uniform in the logarithm.
  double Size(double low, double high) {
    return low * std::exp(Uniform(0.0, std::log(high / low)));
  }
  int Below(int count) {
    return std::min(static_cast<int>(Uniform(0.0, count)), count - 1);
  }
  double Sign() { return Uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0; }

 private:
  std::mt19937_64 engine_;
};

sim::PlantConditions DrawConditions(int kind, int outputs, int inputs,
                                    double settling, double sample_time,
                                    Draws& draws) {
  sim::PlantConditions conditions;
  sim::OutputDisturbanceOptions& output = conditions.output_disturbance;
  const double lag = settling / 5.0;
  switch (kind) {
    case 1:
      output.drift_variance = VectorXd::Constant(
          outputs, std::pow(draws.Size(0.03, 0.2), 2) * sample_time / settling);
      break;
    case 2:
      output.coloured_variance =
          VectorXd::Constant(outputs, std::pow(draws.Size(0.02, 0.1), 2));
      output.coloured_time_constant = lag * draws.Size(0.2, 3.0);
      break;
    case 3:
      for (int j = 0; j < inputs; ++j) {
        conditions.loads.push_back(
            {.input = j,
             .variance = std::pow(draws.Size(0.02, 0.1), 2),
             .time_constant = lag * draws.Size(0.3, 3.0)});
      }
      break;
    case 4:
      output.step_deviation =
          VectorXd::Constant(outputs, draws.Size(0.03, 0.15));
      output.step_rate = 1.0 / (settling * draws.Size(2.0, 10.0));
      break;
    case 5:
      for (int i = 0; i < outputs; ++i) {
        output.sines.push_back({.output = i,
                                .amplitude = draws.Size(0.03, 0.1),
                                .period = settling * draws.Size(0.2, 3.0)});
      }
      break;
    default:
      break;
  }
  return conditions;
}

// A change of one parameter of an element: ln of the factor.
struct Change {
  int output = 0;
  int input = 0;
  int parameter = 0;  // 0: gain, 1: time constant, 2: dead time
  double log_factor = 0.0;
};

ProcessModel WithChange(const ProcessModel& model, const Change& change) {
  ProcessModel changed = model;
  TransferFunction& element = changed.element(change.output, change.input);
  const absl::StatusOr<ElementResponse> response =
      ElementResponse::Create(element);
  CHECK(response.ok()) << response.status();
  ElementValues values = response->initial_values();
  const double factor = std::exp(change.log_factor);
  if (change.parameter == 0) values.gain *= factor;
  if (change.parameter == 1) values.time_scale *= factor;
  // In units of dead time and lag together: most dead times are short.
  if (change.parameter == 2) {
    values.delay = std::max(
        0.0, values.delay +
                 (factor - 1.0) * (values.delay + 0.5 * values.time_scale));
  }
  element = response->ToTransferFunction(values);
  return changed;
}

Change DrawChange(const ProcessModel& model, Draws& draws) {
  Change change;
  do {
    change.output = draws.Below(model.num_outputs());
    change.input = draws.Below(model.num_inputs());
  } while (model.element(change.output, change.input).IsZero());
  change.parameter = draws.Below(3);
  const double size = draws.Size(0.15, 0.5);
  change.log_factor = change.parameter == 2 ? size : draws.Sign() * size;
  return change;
}

// The change that is proposed in place of the true one.
Change Propose(Proposal proposal, Change change, const ProcessModel& model,
               Draws& draws) {
  switch (proposal) {
    case Proposal::kSmall:
      change.log_factor *= 0.5;
      break;
    case Proposal::kTwice:
      change.log_factor *= 2.0;
      break;
    case Proposal::kOppositeSign:
      change.log_factor *= -1.0;
      break;
    case Proposal::kOtherElement: {
      std::vector<int> others;
      for (int j = 0; j < model.num_inputs(); ++j) {
        if (j != change.input && !model.element(change.output, j).IsZero()) {
          others.push_back(j);
        }
      }
      change.input = others[draws.Below(static_cast<int>(others.size()))];
      change.log_factor *= draws.Sign();
      break;
    }
    case Proposal::kOtherParameter:
      change.parameter = (change.parameter + 1 + draws.Below(2)) % 3;
      if (change.parameter != 2) change.log_factor *= draws.Sign();
      break;
    default:
      break;
  }
  return change;
}

// The plant `truth` under a controller with `model`, for the noise of `loop`.
// Fails where the loop is not stable.
absl::StatusOr<Record> RunLoop(const TrialPlant& plant,
                               const ProcessModel& model,
                               const ProcessModel& truth,
                               const sim::SetPointProfile& profile,
                               double duration, sim::ClosedLoopOptions loop,
                               const sim::PlantConditions& conditions) {
  absl::StatusOr<control::Mpc> mpc = control::Mpc::Create(model, plant.tuning);
  CHECK(mpc.ok()) << mpc.status();
  loop.sample_time = plant.sample_time;
  loop.control_period = plant.tuning.control_period;
  loop.duration =
      std::floor(duration / loop.control_period) * loop.control_period;
  return sim::SimulateClosedLoop(
      truth,
      [&mpc](const auto& measured, const auto& wanted, auto next) {
        mpc->Step(measured, wanted, next);
      },
      profile, loop, conditions);
}

}  // namespace

TrialPlant ReadTrialPlant(const std::string& path, std::vector<double> steps,
                          double sample_time, double control_period,
                          int horizon) {
  absl::StatusOr<ProcessModel> read = ReadProcessModel(path);
  CHECK(read.ok()) << read.status();
  TrialPlant plant{.model = *std::move(read)};
  ProcessModel& model = plant.model;
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  const VectorXd step = Eigen::Map<const VectorXd>(steps.data(), p);
  const MatrixXd inverse = StaticGains(model).inverse();
  const VectorXd size = (inverse * step.asDiagonal())
                            .cwiseAbs()
                            .rowwise()
                            .maxCoeff()
                            .cwiseMax((inverse * step).cwiseAbs());
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      std::vector<double> numerator = element.numerator();
      for (double& value : numerator) value *= size(j) / step(i);
      model.element(i, j) = TransferFunction(
          std::move(numerator), element.denominator(), element.delay());
    }
  }
  plant.settling = SettlingTime(model);
  plant.sample_time = sample_time;
  plant.tuning.control_period = control_period;
  plant.tuning.prediction_horizon = horizon;
  plant.tuning.output_weight = MatrixXd::Identity(p, p);
  plant.tuning.move_weight = MatrixXd::Identity(m, m);
  return plant;
}

TrialLife::TrialLife(const TrialPlant& plant, Proposal proposal,
                     std::uint64_t seed)
    : plant_(plant), seed_(seed), truth_(plant.model) {
  Draws draws(seed, kPlantStream);
  const int p = plant.model.num_outputs();
  disturbance_ = draws.Below(kDisturbances);
  noise_ = draws.Size(0.015, 0.06);
  conditions_ = DrawConditions(disturbance_, p, plant.model.num_inputs(),
                               plant.settling, plant.sample_time, draws);
  const Change change = DrawChange(plant.model, draws);
  if (proposal != Proposal::kNothingAged) {
    truth_ = WithChange(plant.model, change);
  }
  sim::SetPointProfile profile;
  for (int c = 0; c < 2 * p; ++c) {
    profile.steps.push_back(
        {.output = c % p,
         .time = plant.settling * (1.5 * c + kQuietSettlings),
         .value = c < p ? 1.0 : 0.0});
  }
  first_record_ =
      Simulate(plant.model, truth_, profile,
               plant.settling * (3.0 * p + kQuietSettlings), kRunStream);
  if (proposal != Proposal::kEstimated) {
    proposed_ =
        WithChange(plant.model, Propose(proposal, change, plant.model, draws));
    if (proposal == Proposal::kOneOfTwo) {
      Change wrong = change;
      while (wrong.output == change.output) {
        wrong = DrawChange(plant.model, draws);
      }
      proposed_ = WithChange(*proposed_, wrong);
    }
    return;
  }
  CorrectOptions options;
  options.threads = 1;
  options.make_arx = false;
  options.filter.estimate = false;
  const absl::StatusOr<CorrectionResult> result =
      CorrectFromRecords(plant.model, {first_record_}, options);
  if (result.ok() && result->accepted()) proposed_ = result->model;
}

Record TrialLife::Simulate(const ProcessModel& model, const ProcessModel& truth,
                           const sim::SetPointProfile& profile, double duration,
                           std::uint64_t stream) const {
  absl::StatusOr<Record> record = RunLoop(
      plant_, model, truth, profile, duration,
      {.noise_variance = noise_ * noise_, .seed = seed_, .stream = stream},
      conditions_);
  if (!record.ok()) return Record();  // The loop is not stable.
  return *std::move(record);
}

Record TrialLife::Day(const ProcessModel& model, const ProcessModel& truth,
                      int day) const {
  const auto stream = kRunStream + 1 + static_cast<std::uint64_t>(day);
  Draws draws(seed_, kWatchStream + stream);
  sim::SetPointProfile profile;
  if (draws.Uniform(0.0, 1.0) < 0.5) {
    profile.steps = {{.output = draws.Below(plant_.model.num_outputs()),
                      .time = plant_.settling * draws.Uniform(1.5, 4.0),
                      .value = draws.Sign() * draws.Uniform(0.5, 1.0)}};
  }
  Record record =
      Simulate(model, truth, profile, kDaySettlings * plant_.settling, stream);
  // Days do not follow each other: each begins at rest.
  record.start_time = 2.0 * kDaySettlings * plant_.settling * day;
  return record;
}

double TrialLife::ControlCost(const ProcessModel& model) const {
  const int p = plant_.model.num_outputs();
  double sum = 0.0;
  for (int c = 0; c < 2 * p; ++c) {
    sim::SetPointProfile profile;
    sim::PlantConditions conditions;
    if (c < p) {
      profile.steps = {{.output = c, .time = 0.0, .value = 1.0}};
    } else {
      conditions.output_disturbance.steps = {
          {.output = c - p, .step = {.time = 0.0, .size = 1.0}}};
    }
    const absl::StatusOr<Record> record =
        RunLoop(plant_, model, truth_, profile, 3.0 * plant_.settling,
                {.noise_variance = 0.0}, conditions);
    if (!record.ok()) return kInfinity;
    sum += (record->outputs - record->set_points).squaredNorm();
  }
  return sum;
}

double TrialLife::Distance(const ProcessModel& model) const {
  constexpr int kSamples = 201;
  const double step = plant_.settling / (kSamples - 1);
  return CompareResponses(truth_.ComputeStepResponse(step, kSamples),
                          model.ComputeStepResponse(step, kSamples))
      .total;
}

}  // namespace mle::benchmarks
