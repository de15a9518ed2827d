#include "apps/lifecycle/life.h"

#include <cmath>
#include <deque>
#include <utility>

#include "control/mpc.h"
#include "control/mpc_options.h"
#include "mle/base/status.h"
#include "sim/closed_loop.h"

namespace mle::lifecycle {
namespace {

using Kind = Policy::Kind;

// A squared error that is none.
constexpr double kRounding = 1e-18;

// Performance of a loop in a set-point change, from its record alone, relative
// to its design:
//
//   index = J_design / J_achieved,   J = Σ_i Σ_k (y_i(k) − r_i(k))²,
//
// from the change to the end of the window. J_design is that of the controller
// on its own model, plus the measurement noise; a loop as designed has an index
// around 1, one whose plant has aged a smaller one. (The design-case benchmark:
// Patwardhan and Shah, J. Process Control 12, 2002, 475–489.)
//
// `window` holds one change of set point, at sample `change`.
absl::StatusOr<double> PerformanceIndex(const ProcessModel& model,
                                        const control::MpcOptions& controller,
                                        const Record& window, int change,
                                        double noise_variance) {
  const int samples = window.samples() - change;
  const auto errors = window.outputs - window.set_points;
  const double achieved = errors.rightCols(samples).squaredNorm();

  // The design: the same step from rest. Limits of inputs and outputs are where
  // they were, seen from there.
  const Eigen::VectorXd inputs = window.inputs.col(change);
  const Eigen::VectorXd before = window.set_points.col(change - 1);
  control::MpcOptions options = controller;
  const auto shift = [](Eigen::VectorXd& limits, const Eigen::VectorXd& by) {
    if (limits.size() > 0) limits -= by;
  };
  shift(options.limits.min_input, inputs);
  shift(options.limits.max_input, inputs);
  shift(options.limits.min_output, before);
  shift(options.limits.max_output, before);
  MLE_ASSIGN_OR_RETURN(control::Mpc mpc, control::Mpc::Create(model, options));
  sim::SetPointProfile profile;
  for (int i = 0; i < model.num_outputs(); ++i) {
    profile.steps.push_back({i, 0.0, window.set_points(i, change) - before[i]});
  }
  sim::ClosedLoopOptions loop;
  loop.sample_time = window.sample_time;
  loop.control_period = controller.control_period;
  loop.duration = (samples - 0.5) * window.sample_time;
  loop.noise_variance = 0.0;
  MLE_ASSIGN_OR_RETURN(const Record design,
                       sim::SimulateClosedLoop(
                           model,
                           [&mpc](const auto& y, const auto& r, auto next) {
                             mpc.Step(y, r, next);
                           },
                           profile, loop));
  const double noise =
      noise_variance * static_cast<double>(samples * model.num_outputs());
  const double designed =
      (design.outputs - design.set_points).squaredNorm() + noise;
  return achieved > 0.0 ? designed / achieved : 1.0;
}

class Years {
 public:
  Years(const Scenario& scenario, const Policy& policy,
        const LifeOptions& options, Operation operation, ModelInUse model)
      : scenario_(scenario),
        policy_(policy),
        options_(options),
        operation_(std::move(operation)),
        model_(std::move(model)) {
    options_.update.correct.estimation.estimator = policy.estimator;
  }

  absl::StatusOr<ChangeRow> Change(const SetPointEvent& event) {
    const double period = options_.operation.controller.control_period;
    const ProcessModel plant = scenario_.PlantAt(event.time);
    if (policy_.kind == Kind::kPerfect) {
      MLE_ASSIGN_OR_RETURN(model_, UseProcess(plant, period));
    }
    ChangeRow row;
    row.event = event;
    MLE_ASSIGN_OR_RETURN(
        row.error,
        CompareWithPlant(model_, plant, options_.operation.sample_time,
                         options_.update.response_samples));
    MLE_ASSIGN_OR_RETURN(ChangeOperation operation,
                         operation_.RunChange(model_.prediction));
    row.quiet = std::move(operation.quiet);
    row.transient = std::move(operation.transient);
    row.test =
        control::OperationSums::Zero(plant.num_outputs(), plant.num_inputs());
    row.watch = row.test;
    quiet_square_ = std::move(operation.quiet_square);
    if (event.output >= 0) {
      windows_.push_front(std::move(operation.window));
      MLE_RETURN_IF_ERROR(Maintain(row));
      while (static_cast<int>(windows_.size()) >= options_.windows) {
        windows_.pop_back();
      }
    }
    return row;
  }

 private:
  // After a change, whose record is windows_.front().
  absl::Status Maintain(ChangeRow& row) {
    ++changes_;
    switch (policy_.kind) {
      case Kind::kNever:
      case Kind::kPerfect:
        return absl::OkStatus();
      case Kind::kCorrection:
        if (changes_ % policy_.every != 0) return absl::OkStatus();
        return Update(RecordsForCorrection(), row);
      case Kind::kTest:
        if (operation_.now() < next_test_ * policy_.months * options_.month) {
          return absl::OkStatus();
        }
        next_test_ = 1.0 + std::floor(operation_.now() /
                                      (policy_.months * options_.month));
        return Test(row);
      case Kind::kOnDemand:
        MLE_ASSIGN_OR_RETURN(row.index, IndexOfLastChange());
        return row.index < policy_.threshold ? Test(row) : absl::OkStatus();
    }
    return absl::OkStatus();
  }

  absl::StatusOr<double> IndexOfLastChange() const {
    const Record& window = windows_.front();
    const std::vector<SetPointChange> changes = FindSetPointChanges(window);
    return PerformanceIndex(model_.process, options_.operation.controller,
                            window, changes.front().sample,
                            options_.operation.noise_variance);
  }

  // Oldest first.
  std::vector<Record> RecordsForCorrection() const {
    std::vector<Record> records;
    for (const Record& window : windows_) {
      if (operation_.now() - window.start_time > options_.window_age) break;
      records.insert(records.begin(), window);
    }
    if (records.empty()) records.push_back(windows_.front());
    return records;
  }

  absl::Status Update(const std::vector<Record>& records, ChangeRow& row) {
    UpdateResult result = UpdateModel(model_, records, options_.update);
    row.outcome = result.outcome;
    row.reason = std::move(result.reason);
    row.held_out_gain = result.held_out_gain;
    if (!result.model.has_value()) return absl::OkStatus();
    if (std::isfinite(options_.watch_limit)) {
      MLE_ASSIGN_OR_RETURN(const bool worse, RunsWorse(*result.model, row));
      if (worse) {
        row.outcome = Outcome::kReverted;
        row.reason = "the loop ran worse with it";
        return absl::OkStatus();
      }
    }
    model_ = *std::move(result.model);
    return absl::OkStatus();
  }

  // Tries a new model on the plant.
  absl::StatusOr<bool> RunsWorse(const ModelInUse& model, ChangeRow& row) {
    absl::StatusOr<WatchOperation> watch =
        operation_.RunWatch(model.prediction);
    // A loop that runs away within hours is stopped long before its numbers
    // mean anything.
    if (watch.status().code() == absl::StatusCode::kFailedPrecondition) {
      return true;
    }
    MLE_RETURN_IF_ERROR(watch.status());
    row.watch = std::move(watch->sums);
    return (watch->square.array() >
            options_.watch_limit * quiet_square_.array() + kRounding)
        .any();
  }

  absl::Status Test(ChangeRow& row) {
    MLE_ASSIGN_OR_RETURN(
        TestOperation test,
        operation_.RunStepTest(PlanStepTest(model_.process, options_.test)));
    row.test = std::move(test.sums);
    return Update({test.record}, row);
  }

  const Scenario& scenario_;
  const Policy& policy_;
  LifeOptions options_;
  Operation operation_;
  ModelInUse model_;
  std::deque<Record> windows_;    // the newest first
  Eigen::VectorXd quiet_square_;  // p, before the last change
  int changes_ = 0;
  double next_test_ = 1.0;  // in the policy's intervals
};

}  // namespace

control::OperationSums ChangeRow::Total() const {
  control::OperationSums total = quiet;
  total.Add(transient);
  total.Add(test);
  total.Add(watch);
  return total;
}

absl::StatusOr<Life> LiveThrough(const Scenario& scenario, const Policy& policy,
                                 const LifeOptions& options,
                                 const std::function<bool()>& stop) {
  MLE_ASSIGN_OR_RETURN(Operation operation,
                       Operation::Create(scenario, options.operation));
  MLE_ASSIGN_OR_RETURN(
      ModelInUse model,
      UseProcess(scenario.model, options.operation.controller.control_period));
  LifeOptions stoppable = options;
  stoppable.update.correct.progress = [&stop](const RunProgress&) {
    return !stop();
  };
  Years years(scenario, policy, stoppable, std::move(operation),
              std::move(model));
  Life life;
  for (const SetPointEvent& event : scenario.events) {
    absl::StatusOr<ChangeRow> row = years.Change(event);
    // A change during which the run was stopped is not kept.
    if (stop()) return absl::CancelledError("stopped");
    if (row.status().code() == absl::StatusCode::kFailedPrecondition) {
      life.ended = std::string(row.status().message());
      return life;
    }
    MLE_RETURN_IF_ERROR(row.status());
    life.rows.push_back(*std::move(row));
  }
  return life;
}

}  // namespace mle::lifecycle
