#include <vector>

#include "Eigen/Core"
#include "apps/simulate/request.h"
#include "control/mpc.h"
#include "mle/base/status.h"
#include "mle/data/sampling.h"

namespace mle::simulate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Set points at the control instants of the run and H_p beyond its end.
MatrixXd SampleAhead(const Simulation& simulation) {
  const double period = simulation.loop.control_period;
  const int instants = SampleCount(period, simulation.loop.duration) +
                       simulation.controller.prediction_horizon;
  return simulation.set_points.Sample(simulation.model.num_outputs(), period,
                                      instants + 1);
}

// The operating points of channels that have a transform in the model.
template <typename Channel>
VectorXd OffsetsOf(const std::vector<Channel>& channels, VectorXd operating) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].transform.IsNone()) {
      operating[static_cast<Eigen::Index>(i)] = 0.0;
    }
  }
  return operating;
}

// Limits of deviations from the operating point as those of values.
control::MpcOptions LimitsOfValues(const Simulation& simulation) {
  control::MpcOptions options = simulation.controller;
  const VectorXd inputs =
      OffsetsOf(simulation.model.inputs(), simulation.operating_inputs);
  const VectorXd outputs =
      OffsetsOf(simulation.model.outputs(), simulation.operating_outputs);
  for (VectorXd* limits :
       {&options.limits.min_input, &options.limits.max_input}) {
    if (limits->size() > 0) *limits += inputs;
  }
  for (VectorXd* limits :
       {&options.limits.min_output, &options.limits.max_output}) {
    if (limits->size() > 0) *limits += outputs;
  }
  return options;
}

// The predictive controller as the loop calls it.
class LoopController {
 public:
  LoopController(control::Mpc mpc, const Simulation& simulation)
      : mpc_(std::move(mpc)),
        operating_inputs_(
            OffsetsOf(simulation.model.inputs(), simulation.operating_inputs)),
        operating_outputs_(OffsetsOf(simulation.model.outputs(),
                                     simulation.operating_outputs)),
        feed_forward_(simulation.feed_forward),
        preview_(simulation.preview),
        disturbance_inputs_(mpc_.model().InputsOf(InputRole::kDisturbance)),
        disturbances_(disturbance_inputs_.size()),
        set_points_ahead_(SampleAhead(simulation)),
        measured_(operating_outputs_),
        set_points_(operating_outputs_) {
    set_points_ahead_.colwise() += operating_outputs_;
    mpc_.Restart(operating_inputs_, operating_outputs_);
  }

  void Step(const Eigen::Ref<const VectorXd>& measured,
            const Eigen::Ref<const VectorXd>& set_points,
            Eigen::Ref<VectorXd> next) {
    measured_ = measured + operating_outputs_;
    set_points_ = set_points + operating_outputs_;
    if (feed_forward_ && !disturbance_inputs_.empty()) {
      for (std::size_t d = 0; d < disturbance_inputs_.size(); ++d) {
        disturbances_[static_cast<Eigen::Index>(d)] =
            next[disturbance_inputs_[d]] +
            operating_inputs_[disturbance_inputs_[d]];
      }
      mpc_.MeasureDisturbances(disturbances_);
    }
    if (preview_) {
      mpc_.StepWithPreview(measured_,
                           set_points_ahead_.middleCols(
                               instant_ + 1, mpc_.options().prediction_horizon),
                           next);
    } else {
      mpc_.Step(measured_, set_points_, next);
    }
    next -= operating_inputs_;
    ++instant_;
  }

 private:
  control::Mpc mpc_;
  // Of channels with a transform in the controller's model, else 0.
  VectorXd operating_inputs_;
  VectorXd operating_outputs_;
  bool feed_forward_ = false;
  bool preview_ = false;
  std::vector<int> disturbance_inputs_;
  VectorXd disturbances_;
  MatrixXd set_points_ahead_;  // p × instants
  VectorXd measured_;
  VectorXd set_points_;
  Eigen::Index instant_ = 0;
};

}  // namespace

absl::StatusOr<Record> Run(Simulation& simulation) {
  MLE_RETURN_IF_ERROR(simulation.loop.Validate());
  MLE_RETURN_IF_ERROR(
      simulation.set_points.Validate(simulation.model.num_outputs()));
  MLE_ASSIGN_OR_RETURN(
      control::Mpc mpc,
      control::Mpc::Create(simulation.model, LimitsOfValues(simulation)));
  LoopController controller(std::move(mpc), simulation);
  MLE_ASSIGN_OR_RETURN(
      Record record,
      sim::SimulateClosedLoop(
          *simulation.plant, simulation.model,
          [&controller](const auto& measured, const auto& set_points,
                        auto next) {
            controller.Step(measured, set_points, next);
          },
          simulation.set_points, simulation.loop, simulation.conditions));
  record.inputs.colwise() += simulation.operating_inputs;
  record.outputs.colwise() += simulation.operating_outputs;
  record.set_points.colwise() += simulation.operating_outputs;
  return record;
}

}  // namespace mle::simulate
