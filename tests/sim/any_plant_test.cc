// The closed loop around plants that are no transfer matrix.

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/ageing_plant.h"
#include "sim/closed_loop.h"
#include "sim/van_de_vusse.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using Eigen::VectorXd;
using ::mle::testing::SingleLoop;
using ::testing::HasSubstr;

// u ← u + gain (r − y): stable if slow enough.
Controller Integral(double gain) {
  return [gain](const auto& y, const auto& r, auto next) {
    next += gain * (r - y);
  };
}

TEST(AnyPlantTest, TheGeneralLoopEqualsTheOneOfATransferMatrix) {
  const ProcessModel model =
      SingleLoop(TransferFunction::FirstOrder(2.0, 3.0, 0.55));
  const SetPointProfile set_points{.steps = {{0, 5.0, 1.0}}};
  absl::StatusOr<AgeingPlant> plant = AgeingPlant::Create(model, {}, {});
  ASSERT_TRUE(plant.ok()) << plant.status();
  const auto general =
      SimulateClosedLoop(*plant, model, Integral(0.05), set_points, {});
  const auto special =
      SimulateClosedLoop(model, Integral(0.05), set_points, {});
  ASSERT_TRUE(general.ok() && special.ok());
  EXPECT_EQ(general->outputs, special->outputs);
  EXPECT_EQ(general->inputs, special->inputs);
}

// Integral action takes the output to its set point whatever the gain becomes.
TEST(AnyPlantTest, ALoopAroundAnAgeingPlantSettles) {
  const ProcessModel model =
      SingleLoop(TransferFunction::FirstOrder(2.0, 3.0, 0.55));
  absl::StatusOr<Schedule> gain =
      Schedule::Create({{100.0, 1.0}, {100.0, 0.5}});
  ASSERT_TRUE(gain.ok());
  absl::StatusOr<AgeingPlant> plant =
      AgeingPlant::Create(model, {{{.gain = *gain}}}, {});
  ASSERT_TRUE(plant.ok()) << plant.status();
  const auto record = SimulateClosedLoop(
      *plant, model, Integral(0.05), {.steps = {{0, 0.0, 1.0}}},
      {.duration = 400.0, .noise_variance = 0.0});
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_NEAR(record->inputs(0, 499), 0.5, 1e-6);   // just before the event
  EXPECT_NEAR(record->inputs(0, 2000), 1.0, 1e-6);  // long after it
  EXPECT_NEAR(record->outputs(0, 2000), 1.0, 1e-6);
}

// Its channels and gains: what the loop needs to know of the reactor.
ProcessModel ReactorChannels() {
  ProcessModel model("reactor", "h", {{"feed", "1/h"}, {"heat", "kJ/h"}},
                     {{"product", "mol/L"}, {"temperature", "degC"}});
  model.element(0, 0) = TransferFunction::FirstOrder(0.023, 0.1, 0.0);
  model.element(1, 1) = TransferFunction::FirstOrder(0.0046, 0.1, 0.0);
  return model;
}

TEST(AnyPlantTest, TheReactorFollowsItsTemperature) {
  absl::StatusOr<ContinuousSystem> system =
      MakeVanDeVusseReactor({.feed = 8.0});
  ASSERT_TRUE(system.ok()) << system.status();
  absl::StatusOr<ContinuousPlant> plant =
      ContinuousPlant::Create(*system, {.sample_time = 0.01});
  ASSERT_TRUE(plant.ok()) << plant.status();
  const auto record =
      SimulateClosedLoop(*plant, ReactorChannels(),
                         [](const auto& y, const auto& r, auto next) {
                           next[1] += 20.0 * (r[1] - y[1]);
                         },
                         {.steps = {{1, 0.5, -3.0}}},
                         {.sample_time = 0.01,
                          .control_period = 0.02,
                          .duration = 10.0,
                          .noise_variance = 0.0});
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_EQ(record->outputs(1, 50), 0.0);
  EXPECT_NEAR(record->outputs(1, 1000), -3.0, 1e-6);
}

TEST(AnyPlantTest, APlantThatBlowsUpIsReported) {
  ContinuousSystem system;
  system.num_inputs = system.num_outputs = 1;
  system.derivative = [](double, const VectorXd& x, const VectorXd& w,
                         VectorXd& dx) { dx[0] = x[0] * x[0] + w[0]; };
  system.output = [](double, const VectorXd& x, const VectorXd&, VectorXd& y) {
    y = x;
  };
  system.initial_state = VectorXd::Zero(1);
  system.largest_step = 0.01;
  absl::StatusOr<ContinuousPlant> plant = ContinuousPlant::Create(system, {});
  ASSERT_TRUE(plant.ok());
  const auto record = SimulateClosedLoop(
      *plant, SingleLoop(TransferFunction::FirstOrder(1.0, 1.0, 0.0)),
      [](const auto&, const auto&, auto next) { next[0] = 1.0; }, {},
      {.duration = 100.0});
  EXPECT_EQ(record.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(record.status().message()),
              HasSubstr("diverges: output 'y1'"));
}

TEST(AnyPlantTest, AnUnstableLoopAroundAnAgeingPlantIsReported) {
  const ProcessModel model =
      SingleLoop(TransferFunction::FirstOrder(2.0, 3.0, 0.55));
  absl::StatusOr<Schedule> delay = Schedule::Create({{0.0, 0.0}, {50.0, 30.0}});
  ASSERT_TRUE(delay.ok());
  absl::StatusOr<AgeingPlant> plant =
      AgeingPlant::Create(model, {{{.delay = *delay}}}, {});
  ASSERT_TRUE(plant.ok()) << plant.status();
  const auto record = SimulateClosedLoop(*plant, model, Integral(0.2), {},
                                         {.duration = 10000.0});
  EXPECT_EQ(record.status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(AnyPlantTest, PlantAndChannelsMustAgree) {
  absl::StatusOr<ContinuousSystem> system = MakeVanDeVusseReactor({});
  ASSERT_TRUE(system.ok());
  absl::StatusOr<ContinuousPlant> plant = ContinuousPlant::Create(*system, {});
  ASSERT_TRUE(plant.ok());
  const auto record = SimulateClosedLoop(
      *plant, SingleLoop(TransferFunction::FirstOrder(1.0, 1.0, 0.0)),
      Integral(0.1), {}, {});
  EXPECT_THAT(std::string(record.status().message()),
              HasSubstr("the plant has 2 inputs and 2 outputs"));
}

}  // namespace
}  // namespace mle::sim
