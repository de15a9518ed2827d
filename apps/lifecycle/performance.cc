#include "apps/lifecycle/performance.h"

#include <cmath>

#include "control/mpc.h"
#include "mle/base/status.h"
#include "sim/closed_loop.h"

namespace mle::lifecycle {

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

}  // namespace mle::lifecycle
