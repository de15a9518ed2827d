#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "apps/lifecycle/life.h"
#include "mle/base/option_error.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/check_options.h"
#include "sim/plant.h"
#include "sim/plant_model.h"

namespace mle::lifecycle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double Limited(double value, const VectorXd& min, const VectorXd& max, int j) {
  if (min.size() > 0) value = std::max(value, min[j]);
  if (max.size() > 0) value = std::min(value, max[j]);
  return value;
}

// p: mean squared error, as measured, of samples first … end − 1.
VectorXd MeasuredSquare(const Record& record, int first, int end) {
  return (record.outputs - record.set_points)
             .middleCols(first, end - first)
             .rowwise()
             .squaredNorm() /
         std::max(end - first, 1);
}

// Set points that stand.
sim::SetPointProfile Hold(const VectorXd& set_points) {
  sim::SetPointProfile profile;
  for (int i = 0; i < set_points.size(); ++i) {
    profile.steps.push_back({i, 0.0, set_points[i]});
  }
  return profile;
}

sim::SetPointProfile Profile(const SetPointEvent& event, double change_time) {
  sim::SetPointProfile profile = Hold(event.before);
  if (event.output >= 0) {
    profile.steps.push_back(
        {event.output, change_time, event.after[event.output]});
  }
  return profile;
}

int Samples(double time, double sample_time) {
  return static_cast<int>(std::llround(time / sample_time));
}

// A plant about an operating point, with a disturbance of its outputs. It keeps
// what the outputs really were, without measurement noise.
class WatchedPlant final : public sim::PlantModel {
 public:
  // The plant's own inputs are `input_offset` more than those here, and the
  // outputs here `output_offset` more than its own. `disturbance` (p × (N + 1))
  // has one column more than there will be samples.
  WatchedPlant(sim::PlantModel& plant, Eigen::VectorXd input_offset,
               const Eigen::VectorXd& output_offset,
               Eigen::MatrixXd disturbance)
      : plant_(plant),
        input_offset_(std::move(input_offset)),
        truth_(std::move(disturbance)) {
    truth_.colwise() += output_offset;
    Look();
  }

  int num_inputs() const override { return plant_.num_inputs(); }
  int num_outputs() const override { return plant_.num_outputs(); }
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override {
    plant_.Advance(input + input_offset_);
    ++sample_;
    Look();
  }
  const Eigen::VectorXd& outputs() const override { return outputs_; }

  // p × (N + 1); columns of samples that are still to come are the disturbance.
  const Eigen::MatrixXd& truth() const { return truth_; }

 private:
  void Look() {
    truth_.col(sample_) += plant_.outputs();
    outputs_ = truth_.col(sample_);
  }

  sim::PlantModel& plant_;
  Eigen::VectorXd input_offset_;
  Eigen::MatrixXd truth_;
  Eigen::VectorXd outputs_;
  Eigen::Index sample_ = 0;
};

}  // namespace

struct Operation::Stretch {
  double start = 0.0;
  VectorXd base;           // m: inputs at its start
  MatrixXd disturbance;    // p × (N + 1)
  VectorXd input_offset;   // what the plant's own inputs are more,
  VectorXd output_offset;  // and the outputs more than the plant's own
  std::unique_ptr<sim::PlantModel> own;  // unless the plant goes on
  Record record;
  MatrixXd truth;  // p × (N + 1)

  control::OperationSums Sum(int first, int end,
                             const control::OutputLimits& limits) const {
    return control::SumsOf(truth, record.set_points, record.inputs, first, end,
                           record.sample_time, limits);
  }
};

absl::Status OperationOptions::Validate(const ProcessModel& model) const {
  MLE_RETURN_IF_ERROR(sim::CheckPositive("sample_time", sample_time));
  MLE_RETURN_IF_ERROR(sim::CheckNotNegative("noise_variance", noise_variance));
  MLE_RETURN_IF_ERROR(sim::CheckNoneOrNotNegative(
      "disturbance_deviation", disturbance_deviation, model.num_outputs()));
  MLE_RETURN_IF_ERROR(sim::CheckPositive("disturbance_time", disturbance_time));
  MLE_RETURN_IF_ERROR(sim::CheckPositive("before", before));
  MLE_RETURN_IF_ERROR(sim::CheckPositive("after", after));
  MLE_RETURN_IF_ERROR(sim::CheckPositive("quiet_stretch", quiet_stretch));
  MLE_RETURN_IF_ERROR(sim::CheckNotNegative("warm_up", warm_up));
  if (before > Lead()) {
    return InvalidArgument("before = ", before,
                           ", but only quiet_stretch + warm_up = ", Lead(),
                           " are simulated before a change");
  }
  return controller.Validate(model.num_outputs(), model.num_inputs());
}

Operation::Operation(const Scenario& scenario, const OperationOptions& options)
    : scenario_(&scenario),
      options_(options),
      disturbance_(scenario.seed,
                   options.disturbance_deviation.size() > 0
                       ? options.disturbance_deviation
                       : VectorXd::Zero(scenario.plant.num_outputs()),
                   options.disturbance_time, options.sample_time),
      inputs_(VectorXd::Zero(scenario.plant.num_inputs())) {
  const double period = options_.controller.control_period;
  for (double* const length : {&options_.before, &options_.after,
                               &options_.quiet_stretch, &options_.warm_up}) {
    *length = std::ceil(*length / period - 1e-9) * period;
  }
}

absl::StatusOr<Operation> Operation::Create(const Scenario& scenario,
                                            const OperationOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate(scenario.model));
  MLE_RETURN_IF_ERROR(scenario.ageing.Validate(scenario.plant));
  Operation operation(scenario, options);
  if (options.every_sample) {
    MLE_ASSIGN_OR_RETURN(
        sim::AgeingPlant plant,
        sim::AgeingPlant::Create(scenario.plant, scenario.ageing,
                                 {.sample_time = options.sample_time}));
    operation.whole_plant_ =
        std::make_unique<sim::AgeingPlant>(std::move(plant));
  }
  return operation;
}

// Inputs that hold the plant at `wanted`, as near to the last ones and as far
// as the limits allow.
VectorXd Operation::SteadyInputs(const ProcessModel& plant,
                                 const VectorXd& wanted) const {
  MatrixXd gains = StaticGains(plant);
  VectorXd start = inputs_;
  for (int j = 0; j < plant.num_inputs(); ++j) {
    if (plant.inputs()[j].role == InputRole::kManipulated) continue;
    gains.col(j).setZero();
    start[j] = 0.0;
  }
  VectorXd inputs = start + gains.completeOrthogonalDecomposition().solve(
                                wanted - gains * start);
  const control::MpcLimits& limits = options_.controller.limits;
  for (int j = 0; j < plant.num_inputs(); ++j) {
    if (plant.inputs()[j].role != InputRole::kManipulated) continue;
    inputs[j] = Limited(inputs[j], limits.min_input, limits.max_input, j);
  }
  return inputs;
}

// A stretch that begins at rest, or, with every sample, where the last ended.
// Its disturbance must be known.
absl::StatusOr<Operation::Stretch> Operation::Enter(double time,
                                                    const VectorXd& set_points,
                                                    MatrixXd disturbance) {
  Stretch stretch;
  stretch.disturbance = std::move(disturbance);
  const int p = scenario_->plant.num_outputs();
  const int m = scenario_->plant.num_inputs();
  stretch.input_offset = VectorXd::Zero(m);
  stretch.output_offset = VectorXd::Zero(p);
  if (options_.every_sample) {
    stretch.base = inputs_;
    stretch.input_offset = inputs_;
    return stretch;
  }
  const ProcessModel plant = scenario_->PlantAt(time);
  stretch.base = SteadyInputs(plant, set_points - stretch.disturbance.col(0));
  stretch.output_offset = StaticGains(plant) * stretch.base;
  MLE_ASSIGN_OR_RETURN(
      sim::Plant frozen,
      sim::Plant::Create(plant, {.sample_time = options_.sample_time}));
  stretch.own = std::make_unique<sim::Plant>(std::move(frozen));
  return stretch;
}

absl::Status Operation::Simulate(Stretch& stretch,
                                 const sim::SetPointProfile& profile,
                                 std::uint64_t stream,
                                 const sim::Controller& controller) {
  sim::PlantModel& plant = stretch.own ? *stretch.own : *whole_plant_;
  const auto samples = static_cast<double>(stretch.disturbance.cols() - 1);
  WatchedPlant watched(plant, stretch.input_offset, stretch.output_offset,
                       std::move(stretch.disturbance));
  sim::ClosedLoopOptions loop;
  loop.sample_time = options_.sample_time;
  loop.control_period = options_.controller.control_period;
  loop.duration = (samples - 0.5) * options_.sample_time;
  loop.noise_variance = options_.noise_variance;
  loop.seed = scenario_->seed;
  loop.stream = stream;
  inputs_ = stretch.base;
  // The loop deals in deviations from the inputs at its start.
  absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      watched, scenario_->plant,
      [&](const auto& measured, const auto& set_points, auto next) {
        controller(measured, set_points, inputs_);
        next = inputs_ - stretch.base;
      },
      profile, loop);
  if (!record.ok()) {
    return WithPrefix(
        record.status(),
        absl::StrCat("in the stretch that begins at ", stretch.start, " ",
                     scenario_->plant.time_unit(), ": "));
  }
  stretch.record = *std::move(record);
  stretch.record.start_time = stretch.start;
  stretch.record.inputs.colwise() += stretch.base;
  stretch.truth = watched.truth();
  return absl::OkStatus();
}

absl::Status Operation::PrepareController(const control::PredictionModel& model,
                                          const Stretch& stretch,
                                          const VectorXd& set_points) {
  if (options_.every_sample && mpc_.has_value()) {
    return mpc_->ExchangeModel(model, options_.controller);
  }
  MLE_ASSIGN_OR_RETURN(control::Mpc mpc,
                       control::Mpc::Create(model, options_.controller));
  mpc.Restart(stretch.base, set_points);
  mpc_ = std::move(mpc);
  return absl::OkStatus();
}

absl::StatusOr<ChangeOperation> Operation::RunChange(
    const control::PredictionModel& model) {
  const SetPointEvent& event = scenario_->events[next_];
  const double dt = options_.sample_time;
  const double quiet = event.time - now_;
  const double warm_up = options_.every_sample ? 0.0 : options_.warm_up;
  const double counted =
      options_.every_sample ? quiet : std::min(options_.quiet_stretch, quiet);
  const double after = event.output < 0 ? 0.0 : options_.after;
  const double start = event.time - counted - warm_up;
  const auto stream = static_cast<std::uint64_t>(next_) + 1;
  const int change = Samples(counted + warm_up, dt);
  const int end = change + Samples(after, dt);
  const MatrixXd disturbance = disturbance_.Draw(stream, start, end);
  disturbance_.Keep(disturbance, event.time + after);
  MLE_ASSIGN_OR_RETURN(Stretch stretch,
                       Enter(event.time, event.before, disturbance));
  stretch.start = start;
  MLE_RETURN_IF_ERROR(PrepareController(model, stretch, event.before));
  MLE_RETURN_IF_ERROR(
      Simulate(stretch, Profile(event, counted + warm_up), stream,
               [this](const auto& measured, const auto& set_points, auto next) {
                 mpc_->Step(measured, set_points, next);
               }));
  ChangeOperation result;
  const int first = Samples(warm_up, dt);
  result.quiet = control::OperationSums::Zero(scenario_->plant.num_outputs(),
                                              scenario_->plant.num_inputs());
  if (counted > 0.0) {
    result.quiet.Add(stretch.Sum(first, change, options_.limits),
                     quiet / counted);
  }
  result.quiet_square = MeasuredSquare(stretch.record, first, change);
  result.transient = stretch.Sum(change, end, options_.limits);
  if (event.output >= 0) {
    const double before = std::min(options_.before, change * dt);
    MLE_ASSIGN_OR_RETURN(result.window,
                         CutWindow(stretch.record, change, before, after - dt));
  }
  now_ = event.time + after;
  ++next_;
  return result;
}

absl::StatusOr<TestOperation> Operation::RunStepTest(const StepTestPlan& plan) {
  const SetPointEvent& event = scenario_->events[next_ - 1];
  const double dt = options_.sample_time;
  const double period = options_.controller.control_period;
  const int samples = Samples(plan.duration(), dt);
  const auto stream = kStepTestStream + static_cast<std::uint64_t>(next_);
  const MatrixXd disturbance = disturbance_.Draw(stream, now_, samples);
  MLE_ASSIGN_OR_RETURN(Stretch stretch, Enter(now_, event.after, disturbance));
  stretch.start = now_;
  const control::MpcLimits& limits = options_.controller.limits;
  const int m = scenario_->plant.num_inputs();
  int instant = 0;
  MLE_RETURN_IF_ERROR(Simulate(
      stretch, Hold(event.after), stream,
      [&](const auto&, const auto&, auto next) {
        next = stretch.base + plan.InputsAt(++instant * period, m);
        for (int j = 0; j < m; ++j) {
          next[j] = Limited(next[j], limits.min_input, limits.max_input, j);
        }
      }));
  if (options_.every_sample) {
    disturbance_.Keep(disturbance, now_ + plan.duration());
    mpc_->Restart(inputs_, event.after);
  }
  TestOperation result;
  result.sums = stretch.Sum(0, samples, options_.limits);
  result.record = std::move(stretch.record);
  now_ += plan.duration();
  return result;
}

absl::StatusOr<WatchOperation> Operation::RunWatch(
    const control::PredictionModel& model) {
  const VectorXd& set_points = scenario_->events[next_ - 1].after;
  const int samples = Samples(options_.quiet_stretch, options_.sample_time);
  const auto stream = kWatchStream + static_cast<std::uint64_t>(next_);
  const MatrixXd disturbance = disturbance_.Draw(stream, now_, samples);
  MLE_ASSIGN_OR_RETURN(Stretch stretch, Enter(now_, set_points, disturbance));
  stretch.start = now_;
  MLE_RETURN_IF_ERROR(PrepareController(model, stretch, set_points));
  MLE_RETURN_IF_ERROR(
      Simulate(stretch, Hold(set_points), stream,
               [this](const auto& measured, const auto& r, auto next) {
                 mpc_->Step(measured, r, next);
               }));
  if (options_.every_sample) {
    disturbance_.Keep(disturbance, now_ + options_.quiet_stretch);
  }
  now_ += options_.quiet_stretch;
  return WatchOperation{stretch.Sum(0, samples, options_.limits),
                        MeasuredSquare(stretch.record, 0, samples)};
}

}  // namespace mle::lifecycle
