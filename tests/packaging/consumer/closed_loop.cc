// Uses the libraries together: exits with 0 if a controlled tank reaches its
// set point.

#include "sim/closed_loop.h"

#include <cmath>
#include <cstdio>

#include "Eigen/Core"
#include "control/mpc.h"
#include "mle/model/process_model.h"
#include "sim/set_point_profile.h"

int main() {
  mle::ProcessModel tank("tank", "min", {{"valve", "%"}}, {{"level", "m"}});
  tank.element(0, 0) = mle::TransferFunction::FirstOrder(2.5, 4.0, 1.0);

  mle::control::MpcOptions mpc_options;
  mpc_options.output_weight = Eigen::MatrixXd::Constant(1, 1, 0.2);
  mpc_options.move_weight = Eigen::MatrixXd::Constant(1, 1, 0.1);
  auto mpc = mle::control::Mpc::Create(tank, mpc_options);
  if (!mpc.ok()) {
    std::fprintf(stderr, "%s\n", mpc.status().ToString().c_str());
    return 1;
  }

  mle::sim::ClosedLoopOptions loop_options;
  loop_options.duration = 200.0;
  loop_options.noise_variance = 0.0;
  const auto record = mle::sim::SimulateClosedLoop(
      tank,
      [&mpc](const Eigen::Ref<const Eigen::VectorXd>& measured_outputs,
             const Eigen::Ref<const Eigen::VectorXd>& set_points,
             Eigen::Ref<Eigen::VectorXd> next_inputs) {
        mpc->Step(measured_outputs, set_points, next_inputs);
      },
      {{{.output = 0, .time = 50.0, .value = 1.0}}}, loop_options);
  if (!record.ok()) {
    std::fprintf(stderr, "%s\n", record.status().ToString().c_str());
    return 1;
  }
  const double end = record->outputs(0, record->samples() - 1);
  std::printf("level %.17g at the end\n", end);
  return std::abs(end - 1.0) < 1e-3 ? 0 : 1;
}
