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

// The predictive controller as the loop calls it.
class LoopController {
 public:
  LoopController(control::Mpc mpc, const Simulation& simulation)
      : mpc_(std::move(mpc)),
        feed_forward_(simulation.feed_forward),
        preview_(simulation.preview),
        disturbance_inputs_(mpc_.model().InputsOf(InputRole::kDisturbance)),
        disturbances_(disturbance_inputs_.size()),
        set_points_ahead_(SampleAhead(simulation)) {}

  void Step(const Eigen::Ref<const VectorXd>& measured,
            const Eigen::Ref<const VectorXd>& set_points,
            Eigen::Ref<VectorXd> next) {
    if (feed_forward_ && !disturbance_inputs_.empty()) {
      for (std::size_t d = 0; d < disturbance_inputs_.size(); ++d) {
        disturbances_[static_cast<Eigen::Index>(d)] =
            next[disturbance_inputs_[d]];
      }
      mpc_.MeasureDisturbances(disturbances_);
    }
    if (preview_) {
      mpc_.StepWithPreview(measured,
                           set_points_ahead_.middleCols(
                               instant_ + 1, mpc_.options().prediction_horizon),
                           next);
    } else {
      mpc_.Step(measured, set_points, next);
    }
    ++instant_;
  }

 private:
  control::Mpc mpc_;
  bool feed_forward_ = false;
  bool preview_ = false;
  std::vector<int> disturbance_inputs_;
  VectorXd disturbances_;
  MatrixXd set_points_ahead_;  // p × instants
  Eigen::Index instant_ = 0;
};

}  // namespace

absl::StatusOr<Record> Run(Simulation& simulation) {
  MLE_RETURN_IF_ERROR(simulation.loop.Validate());
  MLE_RETURN_IF_ERROR(
      simulation.set_points.Validate(simulation.model.num_outputs()));
  MLE_ASSIGN_OR_RETURN(
      control::Mpc mpc,
      control::Mpc::Create(simulation.model, simulation.controller));
  LoopController controller(std::move(mpc), simulation);
  return sim::SimulateClosedLoop(
      *simulation.plant, simulation.model,
      [&controller](const auto& measured, const auto& set_points, auto next) {
        controller.Step(measured, set_points, next);
      },
      simulation.set_points, simulation.loop, simulation.conditions);
}

}  // namespace mle::simulate
