
#include <cmath>

#include "apps/lifecycle/life.h"
#include "control/mpc.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/closed_loop.h"
#include "tests/apps/lifecycle/small_scenario.h"

namespace mle::lifecycle {
namespace {

using testing::Fouling;
using testing::NoisyTank;
using testing::QuietTank;
using testing::Tank;
using testing::TankScenario;

Operation Make(const Scenario& scenario, const OperationOptions& options) {
  absl::StatusOr<Operation> operation = Operation::Create(scenario, options);
  EXPECT_TRUE(operation.ok()) << operation.status();
  return *std::move(operation);
}

control::PredictionModel Prediction(const ProcessModel& model) {
  return UseProcess(model, 1.0)->prediction;
}

ChangeOperation Next(Operation& operation, const ProcessModel& model) {
  absl::StatusOr<ChangeOperation> change =
      operation.RunChange(Prediction(model));
  EXPECT_TRUE(change.ok()) << change.status();
  return *std::move(change);
}

TEST(OperationTest, WithoutNoiseAndAgeingOnlyTransientsCost) {
  const Scenario scenario = TankScenario(6, {});
  ASSERT_GE(scenario.events.size(), 3u);
  Operation operation = Make(scenario, QuietTank());
  for (const SetPointEvent& event : scenario.events) {
    const ChangeOperation change = Next(operation, Tank());
    EXPECT_LT(change.quiet.squared_error[0], 1e-15);
    EXPECT_LT(change.quiet.movement[0], 1e-9);
    if (event.output < 0) {
      EXPECT_EQ(change.transient.time, 0.0);
      continue;
    }
    // The loop is linear: errors go with the size of the change. At least a
    // dead time of it is off by all of that.
    const double size = event.after[event.output] - event.before[event.output];
    const double relative = change.transient.squared_error[0] / (size * size);
    EXPECT_GT(relative, 3.0);
    EXPECT_LT(relative, 20.0);
    EXPECT_EQ(change.window.samples(), 200);
    EXPECT_EQ(change.window.time(80), event.time);
  }
}

TEST(OperationTest, ATransientIsThatOfTheClosedLoopFromRest) {
  const Scenario scenario = TankScenario(2, {});
  const OperationOptions options = QuietTank();
  Operation operation = Make(scenario, options);
  const SetPointEvent& event = scenario.events[0];
  const ChangeOperation change = Next(operation, Tank());

  absl::StatusOr<control::Mpc> mpc =
      control::Mpc::Create(Tank(), options.controller);
  ASSERT_TRUE(mpc.ok()) << mpc.status();
  sim::ClosedLoopOptions loop;
  loop.sample_time = 1.0;
  loop.noise_variance = 0.0;
  loop.duration = 10.0 + options.after - 0.5;
  const absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      Tank(),
      [&](const auto& y, const auto& r, auto next) { mpc->Step(y, r, next); },
      {.steps = {{0, 10.0, event.after[0]}}}, loop);
  ASSERT_TRUE(record.ok()) << record.status();
  const double expected =
      (record->outputs - record->set_points).rightCols(120).squaredNorm();
  EXPECT_NEAR(change.transient.squared_error[0], expected, 1e-9 * expected);
}

TEST(OperationTest, EverySampleAgreesWithTheShortCut) {
  // Ageing, noise and disturbance; the quiet time of 150 changes. The two draw
  // different noise; their quiet errors are means of some 10⁵ samples against
  // 3·10⁴, correlated over some 30 samples: a few per cent.
  const Scenario scenario = TankScenario(150, Fouling(0.7, 3e5));
  OperationOptions options = NoisyTank();
  control::OperationSums sampled = control::OperationSums::Zero(1, 1);
  control::OperationSums transients = control::OperationSums::Zero(1, 1);
  Operation short_cut = Make(scenario, options);
  options.every_sample = true;
  control::OperationSums whole = control::OperationSums::Zero(1, 1);
  control::OperationSums whole_transients = control::OperationSums::Zero(1, 1);
  Operation all = Make(scenario, options);
  for (std::size_t k = 0; k < scenario.events.size(); ++k) {
    const ChangeOperation a = Next(short_cut, Tank());
    const ChangeOperation b = Next(all, Tank());
    sampled.Add(a.quiet);
    transients.Add(a.transient);
    whole.Add(b.quiet);
    whole_transients.Add(b.transient);
  }
  EXPECT_NEAR(sampled.time, whole.time, 1e-6 * whole.time);
  EXPECT_NEAR(sampled.squared_error[0] / whole.squared_error[0], 1.0, 0.06);
  EXPECT_NEAR(sampled.movement[0] / whole.movement[0], 1.0, 0.03);
  EXPECT_NEAR(transients.squared_error[0] / whole_transients.squared_error[0],
              1.0, 0.03);
}

TEST(OperationTest, NoiseIsTheSameForEveryModel) {
  // Two controllers, one seed: before they act on it the noise they see is the
  // same, so that the same model gives the same record to the last bit.
  const Scenario scenario = TankScenario(8, Fouling(0.7, 8000.0));
  Operation a = Make(scenario, NoisyTank());
  Operation b = Make(scenario, NoisyTank());
  Next(a, Tank());
  Next(b, Tank(2.5));  // the next change does not remember
  const ChangeOperation from_a = Next(a, Tank());
  const ChangeOperation from_b = Next(b, Tank());
  EXPECT_EQ(from_a.window.set_points, from_b.window.set_points);
  // They enter from other inputs and so at a rounding's distance.
  EXPECT_LT((from_a.window.outputs - from_b.window.outputs).norm(), 1e-9);
}

TEST(OperationTest, InputLimitsHoldInRecordsAndStepTests) {
  const Scenario scenario = TankScenario(8, {});
  OperationOptions options = NoisyTank();
  options.controller.limits.min_input = Eigen::VectorXd::Constant(1, -0.4);
  options.controller.limits.max_input = Eigen::VectorXd::Constant(1, 0.4);
  Operation operation = Make(scenario, options);
  for (int k = 0; k < 4; ++k) {
    const ChangeOperation change = Next(operation, Tank());
    EXPECT_LE(change.window.inputs.cwiseAbs().maxCoeff(), 0.4 + 1e-12);
  }
  const StepTestPlan plan = PlanStepTest(
      Tank(), {.hold = 50.0, .move = Eigen::VectorXd::Constant(1, 3.0)});
  const absl::StatusOr<TestOperation> test = operation.RunStepTest(plan);
  ASSERT_TRUE(test.ok()) << test.status();
  EXPECT_LE(test->record.inputs.cwiseAbs().maxCoeff(), 0.4 + 1e-12);
}

TEST(OperationTest, AStepTestMovesTheOutputsAsPlannedAndTakesItsTime) {
  const Scenario scenario = TankScenario(2, {});
  Operation operation = Make(scenario, QuietTank());
  Next(operation, Tank());
  const double begin = operation.now();
  const StepTestPlan plan = PlanStepTest(
      Tank(), {.hold = 60.0, .move = Eigen::VectorXd::Constant(1, 0.3)});
  const absl::StatusOr<TestOperation> test = operation.RunStepTest(plan);
  ASSERT_TRUE(test.ok()) << test.status();
  EXPECT_EQ(operation.now() - begin, 120.0);
  EXPECT_EQ(test->sums.time, 120.0);
  const Eigen::RowVectorXd deviation =
      test->record.outputs.row(0) - test->record.set_points.row(0);
  // After 57 min of (60 − dead time) the first-order lag is within e⁻⁷ of it.
  EXPECT_NEAR(deviation.maxCoeff(), 0.3, 0.3 * std::exp(-7.0));
  EXPECT_NEAR(deviation(0), 0.0, 1e-12);
  EXPECT_NEAR(deviation(119), 0.0, 0.3 * std::exp(-6.5));
}

TEST(OperationTest, MistakesAreNamed) {
  OperationOptions options = QuietTank();
  options.before = 500.0;
  const absl::Status status = options.Validate(Tank());
  EXPECT_THAT(std::string(status.message()),
              ::testing::HasSubstr("before = 500"));
}

}  // namespace
}  // namespace mle::lifecycle
