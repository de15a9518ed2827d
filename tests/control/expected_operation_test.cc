#include "control/expected_operation.h"

#include <cmath>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"
#include "sim/closed_loop.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

ProcessModel ReadColumn(const std::string& name) {
  absl::StatusOr<ProcessModel> model =
      ReadProcessModel(std::string(MLE_CONFIG_DIR "/") + name);
  EXPECT_TRUE(model.ok()) << model.status();
  return *std::move(model);
}

Mpc MakeMpc(const ProcessModel& model, double ratio = 0.1) {
  MpcOptions options;
  options.output_weight =
      MatrixXd::Identity(model.num_outputs(), model.num_outputs()) * 0.2;
  options.move_weight =
      MatrixXd::Identity(model.num_inputs(), model.num_inputs()) * 0.1;
  options.disturbance_variance_ratio = ratio;
  absl::StatusOr<Mpc> mpc = Mpc::Create(model, options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return *std::move(mpc);
}

Record Simulate(Mpc mpc, const ProcessModel& plant,
                const sim::SetPointProfile& set_points, double duration,
                double noise_variance, const sim::PlantConditions& conditions) {
  absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      plant,
      [&mpc](const auto& y, const auto& r, auto next) { mpc.Step(y, r, next); },
      set_points,
      {.sample_time = 1.0,
       .duration = duration - 0.5,
       .noise_variance = noise_variance},
      conditions);
  EXPECT_TRUE(record.ok()) << record.status();
  return *std::move(record);
}

// Errors beyond the allowed ones are outputs beyond limits where set points are
// zero.
OperationSums SumsOfRecord(
    const Record& record,
    const VectorXd& allowed = VectorXd::Constant(2, INFINITY)) {
  OperationSums sums = SumsOf(record.outputs, record.set_points, record.inputs,
                              0, record.samples(), 1.0, {-allowed, allowed});
  sums.violation = SumsOf(record.outputs - record.set_points,
                          MatrixXd::Zero(2, record.samples()), record.inputs, 0,
                          record.samples(), 1.0, {-allowed, allowed})
                       .violation;
  return sums;
}

ExpectedOperation Expect(const Mpc& mpc, const ProcessModel& plant,
                         const std::vector<OutputConditions>& conditions) {
  absl::StatusOr<ExpectedOperation> operation =
      ExpectOperation(mpc, plant, conditions);
  EXPECT_TRUE(operation.ok()) << operation.status();
  return *std::move(operation);
}

// The aged column under a controller that believes in the model of old, its set
// points stepping from rest: what is simulated is what is expected.
TEST(ExpectedOperationTest, ChangesWithoutNoiseAreTheSimulatedOnes) {
  const ProcessModel plant = ReadColumn("wood_berry_gain.json");
  const Mpc mpc = MakeMpc(ReadColumn("wood_berry.json"));
  std::vector<OutputConditions> conditions(2);
  conditions[0].changes = 0.001;
  conditions[0].change_size = 0.7;
  conditions[1].changes = 0.003;
  conditions[1].change_size = 0.2;
  conditions[0].allowed_error = 0.3;
  conditions[1].allowed_error = 0.0;
  const ExpectedOperation expected = Expect(mpc, plant, conditions);
  OperationSums simulated = OperationSums::Zero(2, 2);
  for (int i = 0; i < 2; ++i) {
    const Record record =
        Simulate(mpc, plant,
                 {.steps = {{.output = i,
                             .time = 0.0,
                             .value = conditions[i].change_size}}},
                 2000.0, 0.0, {});
    simulated.Add(SumsOfRecord(record, Eigen::Vector2d(0.3, 0.0)),
                  conditions[i].changes);
  }
  EXPECT_EQ(expected.sums.time, 1.0);
  // Both are cut off once a thousandth is left.
  EXPECT_TRUE(
      expected.sums.squared_error.isApprox(simulated.squared_error, 1e-4));
  EXPECT_TRUE(
      expected.sums.absolute_error.isApprox(simulated.absolute_error, 0.01));
  EXPECT_TRUE(expected.sums.movement.isApprox(simulated.movement, 0.01));
  EXPECT_GT(simulated.violation(0), 0.1 * simulated.absolute_error(0));
  EXPECT_NEAR(expected.sums.violation(0) / simulated.violation(0), 1.0, 1e-6);
  EXPECT_DOUBLE_EQ(expected.sums.violation(1), expected.sums.absolute_error(1));
  EXPECT_EQ(expected.resting_variance.norm(), 0.0);
}

// A lag that is over within a period changes nothing; a long one leaves less. A
// walk behind it is a walk less noise that decays, w − x, which the loop
// answers as it answers any other: with a lag of 20 periods the variance is
// that of simulated records to their standard error, 4 %.
TEST(ExpectedOperationTest, AWalkBehindALag) {
  const ProcessModel plant = ReadColumn("wood_berry.json");
  const Mpc mpc = MakeMpc(plant);
  std::vector<OutputConditions> conditions(2);
  conditions[0].walk_variance = 1e-3;
  const VectorXd plain = Expect(mpc, plant, conditions).resting_variance;
  conditions[0].walk_lag = 1e-3;
  EXPECT_TRUE(
      Expect(mpc, plant, conditions).resting_variance.isApprox(plain, 1e-12));
  conditions[0].walk_lag = 20.0;
  const VectorXd lagged = Expect(mpc, plant, conditions).resting_variance;
  EXPECT_LT(lagged(0), plain(0));

  GaussianNoise noise(3, kRunStream, kDriftDisturbance);
  absl::StatusOr<ProcessSimulator> simulator =
      ProcessSimulator::Create(plant, 1.0);
  ASSERT_TRUE(simulator.ok());
  Mpc loop = mpc;
  const double pole = std::exp(-1.0 / 20.0);
  double walk = 0.0;
  VectorXd disturbance = VectorXd::Zero(2);
  VectorXd inputs = VectorXd::Zero(2);
  VectorXd next = inputs;
  VectorXd squares = VectorXd::Zero(2);
  constexpr int kSamples = 200'000;
  for (int k = 0; k < kSamples; ++k) {
    const VectorXd outputs = simulator->outputs() + disturbance;
    squares += outputs.cwiseAbs2();
    loop.Step(outputs, VectorXd::Zero(2), next);
    simulator->Advance(inputs);
    inputs = next;
    disturbance(0) = pole * disturbance(0) + (1.0 - pole) * walk;
    walk += noise.Draw(std::sqrt(1e-3));
  }
  EXPECT_NEAR(squares(0) / kSamples, lagged(0), 0.04 * lagged(0));
  EXPECT_NEAR(squares(1) / kSamples, lagged(1), 0.04 * lagged(1));
}

// Of 400,000 min; a disturbance lasts about 100, so that a mean square is known
// to 2 %.
TEST(ExpectedOperationTest, NoiseAndDisturbancesLeaveTheSimulatedErrors) {
  const ProcessModel plant = ReadColumn("wood_berry_gain.json");
  const Mpc mpc = MakeMpc(ReadColumn("wood_berry.json"));
  const double white = 0.01;
  sim::PlantConditions met;
  met.output_disturbance.drift_variance = Eigen::Vector2d(1e-4, 2e-4);
  met.output_disturbance.coloured_variance = Eigen::Vector2d(0.02, 0.0);
  met.output_disturbance.coloured_time_constant = 30.0;
  std::vector<OutputConditions> conditions(2);
  for (int i = 0; i < 2; ++i) {
    conditions[i].noise_variance = white;
    conditions[i].walk_variance = met.output_disturbance.drift_variance(i);
  }
  for (int h = 0; h < 400; ++h) {
    conditions[0].covariances.push_back(0.02 * std::exp(-h / 30.0));
  }
  const ExpectedOperation expected = Expect(mpc, plant, conditions);
  const Record record = Simulate(mpc, plant, {}, 400'000.0, white, met);
  OperationSums simulated = OperationSums::Zero(2, 2);
  simulated.Add(SumsOfRecord(record), 1.0 / record.samples());
  for (int i = 0; i < 2; ++i) {
    // Measured errors have the noise too.
    const double measured = expected.resting_variance(i) + white;
    EXPECT_NEAR(simulated.squared_error(i) / measured, 1.0, 0.05);
    EXPECT_NEAR(simulated.absolute_error(i) / std::sqrt(2.0 / M_PI * measured),
                1.0, 0.03);
    EXPECT_NEAR(simulated.movement(i) / expected.sums.movement(i), 1.0, 0.02);
    EXPECT_EQ(expected.sums.squared_error(i), expected.resting_variance(i));
    EXPECT_DOUBLE_EQ(expected.sums.absolute_error(i),
                     std::sqrt(2.0 / M_PI * expected.resting_variance(i)));
  }
}

// Under noise a change adds less to the absolute error and to moves: part of
// the error was there.
TEST(ExpectedOperationTest, ChangesUnderNoiseAreTheSimulatedOnes) {
  const ProcessModel plant = ReadColumn("wood_berry_gain.json");
  const Mpc mpc = MakeMpc(ReadColumn("wood_berry.json"));
  sim::PlantConditions met;
  met.output_disturbance.drift_variance = Eigen::Vector2d(2e-3, 2e-3);
  std::vector<OutputConditions> conditions(2);
  conditions[0] = {
      .walk_variance = 2e-3, .changes = 1.0 / 400.0, .change_size = 0.5};
  conditions[1] = {.walk_variance = 2e-3};
  conditions[0].allowed_error = 0.2;
  conditions[1].allowed_error = 0.1;
  sim::SetPointProfile set_points;
  for (int k = 0; k < 1000; ++k) {
    set_points.steps.push_back(
        {.output = 0, .time = 400.0 * k, .value = k % 2 == 0 ? 0.5 : 0.0});
  }
  const ExpectedOperation expected = Expect(mpc, plant, conditions);
  const Record record = Simulate(mpc, plant, set_points, 400'000.0, 0.0, met);
  OperationSums simulated = OperationSums::Zero(2, 2);
  simulated.Add(SumsOfRecord(record, Eigen::Vector2d(0.2, 0.1)),
                1.0 / record.samples());
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(simulated.squared_error(i) / expected.sums.squared_error(i),
                1.0, 0.05);
    EXPECT_NEAR(simulated.absolute_error(i) / expected.sums.absolute_error(i),
                1.0, 0.03);
    EXPECT_NEAR(simulated.violation(i) / expected.sums.violation(i), 1.0, 0.05);
    EXPECT_NEAR(simulated.movement(i) / expected.sums.movement(i), 1.0, 0.02);
  }
}

TEST(ExpectedOperationTest, ALoopThatDoesNotSettleIsRefused) {
  const ProcessModel model =
      testing::SingleLoop(TransferFunction::FirstOrder(1.0, 10.0, 2.0));
  const Mpc mpc = MakeMpc(model);
  const ProcessModel reversed =
      testing::SingleLoop(TransferFunction::FirstOrder(-1.0, 10.0, 2.0));
  const absl::Status status =
      ExpectOperation(mpc, reversed, {OutputConditions()}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("does not settle"));
}

TEST(ExpectedOperationTest, SizesMustAgree) {
  const ProcessModel model =
      testing::SingleLoop(TransferFunction::FirstOrder(1.0, 10.0, 2.0));
  const absl::Status status =
      ExpectOperation(MakeMpc(model), model, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("conditions for 0 outputs"));
}

}  // namespace
}  // namespace mle::control
