#include "control/mpc.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Past inputs are kept for so many times the model's settling time, for a
// slower model to come.
constexpr Eigen::Index kHistoryPerSettling = 2;

std::vector<bool> IntegratingOutputs(const PredictionModel& model) {
  std::vector<bool> integrating(model.num_outputs, false);
  for (Eigen::Index i = 0; i < model.slopes.rows(); ++i) {
    integrating[i] = !model.slopes.row(i).isZero(0.0);
  }
  return integrating;
}

DisturbanceObserver ObserverOf(const PredictionModel& model,
                               const MpcOptions& options) {
  if (options.disturbance_model.has_value()) {
    return DisturbanceObserver(*options.disturbance_model,
                               options.prediction_horizon);
  }
  return DisturbanceObserver(options.VarianceRatios(model.num_outputs),
                             IntegratingOutputs(model));
}

}  // namespace

Mpc::Mpc(PredictionModel model, MpcOptions options, MovePlanner planner)
    : model_(std::move(model)),
      options_(std::move(options)),
      planner_(std::move(planner)),
      observer_(ObserverOf(model_, options_)),
      manipulated_(model_.InputsOf(InputRole::kManipulated)),
      disturbances_(model_.InputsOf(InputRole::kDisturbance)),
      free_response_(model_),
      inputs_(VectorXd::Zero(manipulated_.size())),
      disturbance_inputs_(VectorXd::Zero(disturbances_.size())),
      history_(MatrixXd::Zero(model_.num_inputs(),
                              kHistoryPerSettling * model_.periods() + 1)),
      set_points_(VectorXd::Zero(Eigen::Index{model_.num_outputs} *
                                 options_.prediction_horizon)),
      predicted_(VectorXd::Zero(model_.num_outputs)),
      measured_(predicted_),
      wanted_(predicted_),
      free_outputs_(set_points_),
      error_(set_points_) {}

absl::StatusOr<Mpc> Mpc::CreateAtRest(PredictionModel model,
                                      const MpcOptions& options) {
  if (!(std::abs(model.control_period - options.control_period) <=
        1e-9 * options.control_period)) {
    return InvalidArgument("control_period = ", options.control_period,
                           ", but the prediction model has ",
                           model.control_period);
  }
  if (options.disturbance_model.has_value() && model.IsIntegrating()) {
    return absl::InvalidArgumentError(
        "disturbance_model: an output integrates, which has a ramp as its "
        "disturbance; leave the model out");
  }
  if (model.InputsOf(InputRole::kManipulated).empty()) {
    return absl::InvalidArgumentError(
        "the model has no manipulated input, so nothing can be controlled");
  }
  model.ReachTo(options.prediction_horizon);
  MLE_ASSIGN_OR_RETURN(MovePlanner planner,
                       MovePlanner::Create(model, options));
  return Mpc(std::move(model), options, std::move(planner));
}

absl::StatusOr<Mpc> Mpc::Create(const PredictionModel& model,
                                const MpcOptions& options) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(options.Validate(model.num_outputs, model.num_inputs()));
  return CreateAtRest(model, options);
}

absl::StatusOr<Mpc> Mpc::Create(const ProcessModel& model,
                                const MpcOptions& options) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(
      options.Validate(model.num_outputs(), model.num_inputs()));
  MLE_ASSIGN_OR_RETURN(PredictionModel prediction,
                       PredictFromProcess(model, options.control_period));
  EngineeringVariables variables(model);
  if (!variables.has_transforms()) {
    return CreateAtRest(std::move(prediction), options);
  }
  MpcOptions linear = options;
  MLE_ASSIGN_OR_RETURN(linear.limits, variables.LinearLimits(options.limits));
  MLE_ASSIGN_OR_RETURN(Mpc mpc, CreateAtRest(std::move(prediction), linear));
  mpc.variables_ = std::move(variables);
  const VectorXd outputs = mpc.variables_.OperatingOutputs();
  mpc.Restart(mpc.variables_.OperatingInputs(), outputs);
  for (Eigen::Index row = 0; row < mpc.set_points_.size();
       row += outputs.size()) {
    mpc.set_points_.segment(row, outputs.size()) = outputs;
  }
  return mpc;
}

VectorXd Mpc::PredictedOutputs() const {
  VectorXd outputs = free_response_.At(0) + observer_.disturbance();
  variables_.Outputs(outputs);
  return outputs;
}

void Mpc::Restart(const Eigen::Ref<const VectorXd>& inputs,
                  const Eigen::Ref<const VectorXd>& outputs) {
  CHECK_EQ(inputs.size(), model_.num_inputs());
  CHECK_EQ(outputs.size(), model_.num_outputs);
  VectorXd linear = inputs;
  variables_.LinearInputs(linear);
  inputs_ = linear(manipulated_);
  disturbance_inputs_ = linear(disturbances_);
  history_.colwise() = linear;
  RebuildFreeResponse();
  // The outputs are at rest: what the inputs do not balance, a load does.
  measured_ = outputs;
  variables_.LinearOutputs(measured_);
  observer_.Restart(measured_ - free_response_.At(0), -free_response_.ramp());
}

void Mpc::MeasureDisturbances(const Eigen::Ref<const VectorXd>& disturbances) {
  CHECK_EQ(disturbances.size(), disturbance_inputs_.size());
  for (Eigen::Index j = 0; j < disturbances.size(); ++j) {
    const double value =
        variables_.LinearInput(disturbances_[j], disturbances[j]);
    if (!std::isfinite(value)) continue;
    free_response_.Move(disturbances_[j], value - disturbance_inputs_[j]);
    disturbance_inputs_[j] = value;
    history_(disturbances_[j], newest_) = value;
  }
}

void Mpc::Step(const Eigen::Ref<const VectorXd>& measured_outputs,
               const Eigen::Ref<const VectorXd>& set_points,
               Eigen::Ref<VectorXd> next_inputs) {
  const int p = model_.num_outputs;
  CHECK_EQ(set_points.size(), p);
  wanted_ = set_points;
  variables_.LinearOutputs(wanted_);
  for (int i = 0; i < p; ++i) {
    if (std::isfinite(wanted_[i])) set_points_[i] = wanted_[i];
  }
  for (Eigen::Index row = p; row < set_points_.size(); row += p) {
    set_points_.segment(row, p) = set_points_.head(p);
  }
  PlanAndMove(measured_outputs, next_inputs);
}

void Mpc::StepWithPreview(const Eigen::Ref<const VectorXd>& measured_outputs,
                          const Eigen::Ref<const MatrixXd>& set_points,
                          Eigen::Ref<VectorXd> next_inputs) {
  const int p = model_.num_outputs;
  CHECK_EQ(set_points.rows(), p);
  CHECK_EQ(set_points.cols(), options_.prediction_horizon);
  for (int i = 0; i < options_.prediction_horizon; ++i) {
    wanted_ = set_points.col(i);
    variables_.LinearOutputs(wanted_);
    for (int out = 0; out < p; ++out) {
      const double value = wanted_[out];
      // A missing set point is the one before it: in this plan, or in the last.
      const double before = set_points_[i == 0 ? out : (i - 1) * p + out];
      set_points_[i * p + out] = std::isfinite(value) ? value : before;
    }
  }
  PlanAndMove(measured_outputs, next_inputs);
}

void Mpc::PlanAndMove(const Eigen::Ref<const VectorXd>& measured_outputs,
                      Eigen::Ref<VectorXd> next_inputs) {
  const int p = model_.num_outputs;
  CHECK_EQ(measured_outputs.size(), p);
  CHECK_EQ(next_inputs.size(), model_.num_inputs());

  predicted_ = free_response_.At(0);
  measured_ = measured_outputs;
  variables_.LinearOutputs(measured_);
  observer_.Update(measured_, predicted_);
  for (int i = 0; i < options_.prediction_horizon; ++i) {
    auto outputs = free_outputs_.segment(Eigen::Index{p} * i, p);
    outputs = free_response_.At(i + 1);
    observer_.AddForecast(i + 1, outputs);
  }
  error_ = set_points_ - free_outputs_;
  HoldLastSetPoints();
  last_plan_ = planner_.Plan(error_, free_outputs_, inputs_);
  const Eigen::Index previous = newest_;
  newest_ = (newest_ + 1) % history_.cols();
  history_.col(newest_) = history_.col(previous);
  next_inputs.setZero();
  // On to the next instant, from which the moves act.
  free_response_.Advance();
  const auto planned = planner_.planned_inputs().col(0);
  for (Eigen::Index j = 0; j < inputs_.size(); ++j) {
    const int input = manipulated_[j];
    free_response_.Move(input, planned[j] - inputs_[j]);
    inputs_[j] = planned[j];
    next_inputs[input] = planned[j];
    history_(input, newest_) = planned[j];
  }
  variables_.Inputs(next_inputs);
  for (const int input : disturbances_) next_inputs[input] = 0.0;
  observer_.Advance();
}

// A set point that changes at the end of the horizon is no slope of an
// integrating output (move_planner.h): there it is as an instant before.
void Mpc::HoldLastSetPoints() {
  const Eigen::Index p = model_.num_outputs;
  const Eigen::Index last = error_.size() - p;
  if (last == 0) return;
  for (Eigen::Index i = 0; i < model_.slopes.rows(); ++i) {
    if (model_.slopes.row(i).isZero(0.0)) continue;
    error_[last + i] = set_points_[last - p + i] - free_outputs_[last + i];
  }
}

absl::Status Mpc::ExchangeModel(const PredictionModel& model,
                                const MpcOptions& options) {
  if (model.num_outputs != model_.num_outputs || model.roles != model_.roles) {
    return InvalidArgument(
        "the new model has ", model.num_outputs, " outputs and ",
        model.num_inputs(), " inputs, the running one ", model_.num_outputs,
        " and ", model_.num_inputs(), "; numbers and roles must be the same");
  }
  if (options.control_period != options_.control_period) {
    return InvalidArgument(
        "the new options have control_period = ", options.control_period,
        ", but the loop runs with ", options_.control_period,
        ": a running loop keeps its period");
  }
  MLE_ASSIGN_OR_RETURN(Mpc next, Create(model, options));

  // Past inputs, newest first; what is older than the oldest is as that one.
  const Eigen::Index depth = history_.cols();
  next.history_.conservativeResize(Eigen::NoChange,
                                   std::max(depth, next.history_.cols()));
  const Eigen::Index next_depth = next.history_.cols();
  next.newest_ = next_depth - 1;
  for (Eigen::Index age = 0; age < next_depth; ++age) {
    const Eigen::Index known = std::min(age, depth - 1);
    next.history_.col(next_depth - 1 - age) =
        history_.col((newest_ + depth - known) % depth);
  }
  next.variables_ = variables_;
  next.inputs_ = inputs_;
  next.disturbance_inputs_ = disturbance_inputs_;
  const int p = model_.num_outputs;
  for (Eigen::Index row = 0; row < next.set_points_.size(); row += p) {
    next.set_points_.segment(row, p) = set_points_.head(p);
  }
  next.RebuildFreeResponse();
  next.observer_.Restart(
      free_response_.At(0) + observer_.disturbance() -
          next.free_response_.At(0),
      observer_.slope() + free_response_.ramp() - next.free_response_.ramp());
  *this = std::move(next);
  return absl::OkStatus();
}

// From the oldest inputs on, move by move.
void Mpc::RebuildFreeResponse() {
  const Eigen::Index depth = history_.cols();
  const auto past = [&](Eigen::Index age) {
    return history_.col((newest_ + depth - age) % depth);
  };
  free_response_.Settle(past(depth - 1));
  for (Eigen::Index age = depth - 2; age >= 0; --age) {
    free_response_.Advance();
    for (int j = 0; j < model_.num_inputs(); ++j) {
      free_response_.Move(j, past(age)[j] - past(age + 1)[j]);
    }
  }
}

}  // namespace mle::control
