// Effects of real plants in the closed loop: each against the same plant under
// the input, or with the element, that it amounts to.

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "sim/closed_loop.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::mle::testing::EmptyModel;
using ::mle::testing::MixedModel;
using ::mle::testing::SecondOrder;
using ::mle::testing::SingleLoop;

void AskForNothing(const Eigen::Ref<const VectorXd>&,
                   const Eigen::Ref<const VectorXd>&,
                   Eigen::Ref<VectorXd> next) {
  next.setZero();
}

// Asks for 1 on every input.
void Push(const Eigen::Ref<const VectorXd>&, const Eigen::Ref<const VectorXd>&,
          Eigen::Ref<VectorXd> next) {
  next.setOnes();
}

Record SimulateWithEffects(const ProcessModel& model,
                           const Controller& controller,
                           const PlantConditions& conditions,
                           const ClosedLoopOptions& options = {
                               .duration = 40.0, .noise_variance = 0.0}) {
  absl::StatusOr<Record> record =
      SimulateClosedLoop(model, controller, {}, options, conditions);
  EXPECT_TRUE(record.ok()) << record.status();
  return *std::move(record);
}

// Inputs act from the first control instant, 1.0, on.
TEST(EffectsTest, ALoadActsAsTheInputAndIsNotRecorded) {
  const Record pushed = SimulateWithEffects(MixedModel(), Push, {});
  PlantConditions conditions;
  for (int j = 0; j < 3; ++j) {
    conditions.loads.push_back(
        {.input = j, .steps = {{.time = 1.0, .size = 1.0}}});
  }
  const Record loaded =
      SimulateWithEffects(MixedModel(), AskForNothing, conditions);
  EXPECT_LE((loaded.outputs - pushed.outputs).norm(), 1e-12);
  EXPECT_GT(pushed.outputs.norm(), 1.0);
  EXPECT_EQ(loaded.inputs.norm(), 0.0);
}

// Coloured noise through a static gain of 0.5 and its dead time.
TEST(EffectsTest, ALoadHasItsVarianceAndCorrelation) {
  const ProcessModel plant = SingleLoop(TransferFunction({0.5}, {1.0}, 0.0));
  PlantConditions conditions;
  conditions.loads = {{.input = 0, .variance = 0.3, .time_constant = 2.0}};
  const Record record =
      SimulateWithEffects(plant, AskForNothing, conditions,
                          {.duration = 40000.0, .noise_variance = 0.0});
  const Eigen::Index n = record.outputs.cols() - 1;
  const double variance = record.outputs.squaredNorm() / static_cast<double>(n);
  EXPECT_NEAR(variance / (0.25 * 0.3), 1.0, 0.06);
  const double lag_one =
      record.outputs.row(0).head(n).dot(record.outputs.row(0).tail(n)) /
      static_cast<double>(n);
  EXPECT_NEAR(lag_one / variance, std::exp(-0.2 / 2.0), 0.005);
}

// The input answers the load in full: nothing reaches the plant, and the record
// holds what was answered.
TEST(EffectsTest, ALoadThatIsAnsweredMovesTheRecordedInput) {
  PlantConditions conditions;
  conditions.loads = {{.input = 0, .steps = {{.time = 5.0, .size = 2.0}}}};
  const Record alone =
      SimulateWithEffects(MixedModel(), AskForNothing, conditions);
  for (const double share : {0.25, 1.0}) {
    conditions.loads[0].answered = share;
    const Record answered =
        SimulateWithEffects(MixedModel(), AskForNothing, conditions);
    EXPECT_LE((answered.outputs - (1.0 - share) * alone.outputs).norm(), 1e-12);
    for (int k = 0; k < answered.samples(); ++k) {
      ASSERT_EQ(answered.inputs(0, k),
                answered.time(k) < 5.0 ? 0.0 : -2.0 * share);
    }
  }
  EXPECT_GT(alone.outputs.norm(), 1.0);
}

// The output of a bent sensor is a function of that of a straight one, in the
// loop: the controller sees it.
TEST(EffectsTest, TheControllerSeesABentOutput) {
  const ProcessModel plant = SingleLoop(SecondOrder(1.0, 0.0, 2.0, 1.0, 0.0));
  std::vector<double> seen;
  const Controller push = [&seen](const auto& y, const auto&, auto next) {
    seen.push_back(y[0]);
    next.setOnes();
  };
  PlantConditions conditions;
  conditions.sensors = {{.curve = OutputCurve::kQuadratic, .curvature = 0.2}};
  const Record straight = SimulateWithEffects(plant, Push, {});
  const Record bent = SimulateWithEffects(plant, push, conditions);
  for (int k = 0; k < bent.samples(); ++k) {
    const double y = straight.outputs(0, k);
    ASSERT_NEAR(bent.outputs(0, k), y + 0.2 * y * y, 1e-12);
    if (k % 5 == 0) {
      ASSERT_EQ(seen[k / 5], bent.outputs(0, k));
    }
  }
}

// The controller adds up what it sees of its error; in manual it sees none.
TEST(EffectsTest, InManualTheInputStandsAndTheControllerWaits) {
  const ProcessModel plant =
      SingleLoop(TransferFunction::FirstOrder(1.0, 2.0, 0.0));
  const Controller integrate = [](const auto& y, const auto& r, auto next) {
    next[0] += 0.2 * (r[0] - y[0]);
  };
  PlantConditions conditions;
  conditions.manual = {{.input = 0, .from = 10.0, .to = 20.0, .change = -0.3}};
  const ClosedLoopOptions options{.duration = 200.0, .noise_variance = 0.0};
  const absl::StatusOr<Record> record = SimulateClosedLoop(
      plant, integrate, {.steps = {{.output = 0, .time = 2.0, .value = 1.0}}},
      options, conditions);
  ASSERT_TRUE(record.ok()) << record.status();
  const auto input = [&](double time) {
    return record->inputs(0, static_cast<int>(std::round(time / 0.2)));
  };
  EXPECT_NEAR(input(10.0), input(9.8) - 0.3, 1e-12);
  EXPECT_EQ(input(19.8), input(10.0));
  EXPECT_NE(input(20.0), input(19.8));
  // What it asked for last, 9 control instants' worth of nothing.
  EXPECT_NEAR(input(20.0), input(9.8), 0.2);
  EXPECT_NEAR(record->outputs(0, record->samples() - 1), 1.0, 1e-6);
}

TEST(EffectsTest, AnActuatorStandsBetweenTheRecordAndThePlant) {
  PlantConditions conditions;
  conditions.actuators = {{.input = 0, .stiction = 0.5},
                          {.input = 2, .stiction = 3.0}};
  const Record stuck = SimulateWithEffects(MixedModel(), Push, conditions);
  const Record free = SimulateWithEffects(MixedModel(), Push, {});
  EXPECT_EQ(stuck.inputs, free.inputs);
  // By linearity: 0.75 of the first input, all of the second, none of the
  // third.
  const auto alone = [](int input, double size) {
    PlantConditions load;
    load.loads = {{.input = input, .steps = {{.time = 1.0, .size = size}}}};
    return SimulateWithEffects(MixedModel(), AskForNothing, load).outputs;
  };
  EXPECT_LE((stuck.outputs - alone(0, 0.75) - alone(1, 1.0)).norm(), 1e-12);
}

// Lag and element in a row are a second-order element. The lag takes the output
// as linear between samples: an error of some (Δt/T)²/12.
TEST(EffectsTest, ASensorLagIsAPole) {
  const ProcessModel plant =
      SingleLoop(TransferFunction::FirstOrder(2.0, 3.0, 0.6));
  const ProcessModel both = SingleLoop(SecondOrder(2.0, 0.0, 3.0, 1.5, 0.6));
  PlantConditions conditions;
  conditions.sensors = {{.output = 0, .lag = 1.5}};
  const MatrixXd lagged = SimulateWithEffects(plant, Push, conditions).outputs;
  const MatrixXd exact = SimulateWithEffects(both, Push, {}).outputs;
  EXPECT_LE((lagged - exact).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_GT((SimulateWithEffects(plant, Push, {}).outputs - exact)
                .cwiseAbs()
                .maxCoeff(),
            0.1);
}

// Noise comes after the lag.
TEST(EffectsTest, ASensorHasWhiteNoise) {
  PlantConditions conditions;
  conditions.sensors = {{.output = 1, .lag = 5.0, .noise_variance = 0.09}};
  const MatrixXd outputs =
      SimulateWithEffects(EmptyModel(2, 1), AskForNothing, conditions,
                          {.duration = 4000.0, .noise_variance = 0.0})
          .outputs;
  EXPECT_EQ(outputs.row(0).norm(), 0.0);
  const Eigen::Index n = outputs.cols() - 1;
  const double variance = outputs.row(1).squaredNorm() / static_cast<double>(n);
  EXPECT_NEAR(variance, 0.09, 0.004);  // 20,000 values: 1 %
  EXPECT_NEAR(outputs.row(1).head(n).dot(outputs.row(1).tail(n)) /
                  static_cast<double>(n) / variance,
              0.0, 0.03);
}

TEST(EffectsTest, ASineAndAStepAreAddedToTheirOutput) {
  PlantConditions conditions;
  conditions.output_disturbance.sines = {
      {.output = 0, .amplitude = 0.5, .period = 8.0, .phase = 0.3}};
  conditions.output_disturbance.steps = {{1, {.time = 10.0, .size = 0.4}}};
  const Record record =
      SimulateWithEffects(EmptyModel(2, 1), AskForNothing, conditions);
  for (int k = 0; k < record.samples(); ++k) {
    ASSERT_NEAR(
        record.outputs(0, k),
        0.5 * std::sin(2.0 * std::numbers::pi * record.time(k) / 8.0 + 0.3),
        1e-12);
    ASSERT_EQ(record.outputs(1, k), k < 50 ? 0.0 : 0.4);
  }
}

// Phases that are not given differ, and hold for all amplitudes.
TEST(EffectsTest, PhasesAreDrawn) {
  const auto sines = [](double amplitude) {
    PlantConditions conditions;
    conditions.output_disturbance.sines = {
        {.output = 0, .amplitude = amplitude, .period = 8.0},
        {.output = 1, .amplitude = amplitude, .period = 8.0}};
    return SimulateWithEffects(EmptyModel(2, 1), AskForNothing, conditions)
        .outputs;
  };
  const MatrixXd one = sines(1.0);
  EXPECT_LE((sines(3.0) - 3.0 * one).norm(), 1e-12);
  EXPECT_GT((one.row(0) - one.row(1)).norm(), 0.1);
}

TEST(EffectsTest, ARandomKindLeavesTheOthersAsTheyWere) {
  const ClosedLoopOptions options{.duration = 40.0};
  const MatrixXd noise =
      SimulateWithEffects(EmptyModel(2, 1), AskForNothing, {}, options).outputs;
  PlantConditions conditions;
  conditions.output_disturbance.arma = {
      {1, {.poles = {0.9}, .zeros = {}, .variance = 1.0}}};
  conditions.loads = {{.input = 0, .variance = 1.0}};
  const MatrixXd both =
      SimulateWithEffects(EmptyModel(2, 1), AskForNothing, conditions, options)
          .outputs;
  EXPECT_EQ(both.row(0), noise.row(0));
  const MatrixXd alone =
      SimulateWithEffects(EmptyModel(2, 1), AskForNothing, conditions).outputs;
  EXPECT_LE((both - noise - alone).norm(), 1e-12);
  EXPECT_GT(alone.row(1).norm(), 1.0);
}

}  // namespace
}  // namespace mle::sim
