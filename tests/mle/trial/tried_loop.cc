#include "tests/mle/trial/tried_loop.h"

#include "control/mpc.h"
#include "gtest/gtest.h"
#include "sim/closed_loop.h"

namespace mle {

ProcessModel Tank(double gain) {
  ProcessModel tank("tank", "min", {{.name = "steam"}}, {{.name = "level"}});
  tank.element(0, 0) = TransferFunction::FirstOrder(gain, 10.0, 4.0);
  return tank;
}

Record RecordOf(const TriedLoop& loop, std::uint64_t seed) {
  control::MpcOptions tuning;
  tuning.output_weight = Eigen::MatrixXd::Identity(1, 1);
  tuning.move_weight = Eigen::MatrixXd::Identity(1, 1);
  absl::StatusOr<control::Mpc> mpc =
      control::Mpc::Create(Tank(loop.model_gain), tuning);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  sim::ClosedLoopOptions options;
  options.sample_time = 1.0;
  options.control_period = 1.0;
  options.noise_variance = loop.noise_variance;
  options.seed = seed;
  options.duration = loop.quiet + loop.changes * loop.period;
  sim::SetPointProfile profile;
  for (int c = 0; c < loop.changes; ++c) {
    profile.steps.push_back({.output = 0,
                             .time = loop.quiet + c * loop.period,
                             .value = c % 2 == 0 ? 1.0 : 0.0});
  }
  sim::PlantConditions conditions;
  conditions.output_disturbance.drift_variance =
      Eigen::VectorXd::Constant(1, loop.drift_variance);
  absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      Tank(loop.plant_gain),
      [&mpc](const auto& measured, const auto& wanted, auto next) {
        mpc->Step(measured, wanted, next);
      },
      profile, options, conditions);
  EXPECT_TRUE(record.ok()) << record.status();
  return *std::move(record);
}

}  // namespace mle
