// Plants that age, against closed forms.
//
// With τ(t) = 1 + a t the time constants of an element stretch so that its own
// clock runs as σ(t) = ∫ dt/τ = ln(1 + a t)/a: its response is the unaged one,
// read at σ.

#include "sim/ageing_plant.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "sim/linear_system.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::mle::testing::EmptyModel;
using ::mle::testing::MixedModel;
using ::mle::testing::SecondOrder;
using ::mle::testing::SingleLoop;
using ::testing::HasSubstr;

Schedule Points(std::vector<Schedule::Point> points) {
  absl::StatusOr<Schedule> schedule = Schedule::Create(std::move(points));
  EXPECT_TRUE(schedule.ok()) << schedule.status();
  return *std::move(schedule);
}

AgeingPlant MakeAgeing(const ProcessModel& model, const AgeingSchedule& ageing,
                       const AgeingPlantOptions& options = {}) {
  absl::StatusOr<AgeingPlant> plant =
      AgeingPlant::Create(model, ageing, options);
  EXPECT_TRUE(plant.ok()) << plant.status();
  return *std::move(plant);
}

// p × N: the outputs at 0 … N − 1 under the inputs (m × N).
MatrixXd OutputsOf(PlantModel& plant, const MatrixXd& inputs) {
  MatrixXd outputs(plant.num_outputs(), inputs.cols());
  for (Eigen::Index k = 0; k < inputs.cols(); ++k) {
    outputs.col(k) = plant.outputs();
    plant.Advance(inputs.col(k));
  }
  return outputs;
}

MatrixXd RandomInputs(int inputs, int samples) {
  return GaussianNoise(7, 0).DrawMatrix(inputs, samples, 1.0);
}

// 3 × 3 with first- and second-order elements, leads, inverse responses and
// dead times off the grid.
ProcessModel ThreeByThree() {
  ProcessModel model = EmptyModel(3, 3);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int n = 3 * i + j;
      model.element(i, j) = SecondOrder(1.0 + 0.7 * n, 4.0 - n, 3.0 + n,
                                        0.8 + 0.1 * n, 0.137 + 0.61 * n);
    }
  }
  model.element(1, 1) = TransferFunction::FirstOrder(-3.0, 9.0, 2.03);
  model.element(2, 0) = TransferFunction({4.0, 1.0}, {2.0, 1.0}, 0.77);
  return model;
}

AgeingSchedule AgeingOfEverything(const ProcessModel& model) {
  AgeingSchedule ageing;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (model.element(i, j).IsZero()) continue;
      ageing.elements.push_back(
          {i, j, Points({{3.03, 1.0}, {40.0, 0.5}, {40.0, 0.8}}),
           Points({{0.0, 1.0}, {33.33, 1.7}, {50.0, 1.2}}),
           Points({{10.0, 0.0}, {70.0, 4.0 + i}})});
    }
  }
  return ageing;
}

// The target of the default step, on the general plant: 3 × 3 against the
// matrix exponential.
TEST(LinearSystemTest, StepResponsesOfA3x3PlantAreAccurate) {
  const ProcessModel model = ThreeByThree();
  const int samples = 400;
  const StepResponse exact = model.ComputeStepResponse(0.2, samples);
  absl::StatusOr<ContinuousSystem> system = ToLinearSystem(model);
  ASSERT_TRUE(system.ok()) << system.status();
  for (int j = 0; j < 3; ++j) {
    absl::StatusOr<ContinuousPlant> plant =
        ContinuousPlant::Create(*system, {.sample_time = 0.2});
    ASSERT_TRUE(plant.ok()) << plant.status();
    MatrixXd inputs = MatrixXd::Zero(3, samples);
    inputs.row(j).setOnes();
    const MatrixXd outputs = OutputsOf(*plant, inputs);
    for (int i = 0; i < 3; ++i) {
      EXPECT_LE((outputs.row(i).transpose() - exact.element(i, j)).norm(),
                1e-8 * exact.element(i, j).norm());
    }
  }
}

TEST(LinearSystemTest, EqualsTheFastPlantUnderRandomInputs) {
  for (const ProcessModel& model : {MixedModel(), ThreeByThree()}) {
    absl::StatusOr<ContinuousSystem> system = ToLinearSystem(model);
    ASSERT_TRUE(system.ok()) << system.status();
    absl::StatusOr<ContinuousPlant> general =
        ContinuousPlant::Create(*system, {.sample_time = 0.2});
    absl::StatusOr<Plant> fast = Plant::Create(model, {.sample_time = 0.2});
    ASSERT_TRUE(general.ok() && fast.ok());
    const MatrixXd inputs = RandomInputs(model.num_inputs(), 500);
    const MatrixXd expected = OutputsOf(*fast, inputs);
    // Both are within 1e-8 of the truth, with steps of different length.
    EXPECT_LE((OutputsOf(*general, inputs) - expected).norm(),
              1e-8 * expected.norm());
  }
}

TEST(LinearSystemTest, AModelWithoutElementsStaysAtZero) {
  absl::StatusOr<ContinuousSystem> system = ToLinearSystem(EmptyModel(2, 3));
  ASSERT_TRUE(system.ok()) << system.status();
  absl::StatusOr<ContinuousPlant> plant = ContinuousPlant::Create(*system, {});
  ASSERT_TRUE(plant.ok()) << plant.status();
  EXPECT_EQ(OutputsOf(*plant, RandomInputs(3, 20)).norm(), 0.0);
}

TEST(LinearSystemTest, ShapesAreChecked) {
  LinearCoefficients c{MatrixXd::Zero(2, 2), MatrixXd::Zero(2, 1),
                       MatrixXd::Zero(1, 2), MatrixXd::Zero(1, 2)};
  EXPECT_THAT(
      std::string(
          MakeLinearSystem(c, 1, {{0, Schedule(0.0)}}).status().message()),
      HasSubstr("D 1 × 2 and 1 paths"));
}

// Gain falling from t = 5 on, time constant growing, one after the other and
// together, over a unit step.
TEST(AgeingPlantTest, DriftOfGainAndTimeConstant) {
  const double K = 12.8, T = 16.7, a = 0.02;
  AgeingSchedule ageing;
  ageing.elements.push_back(
      {.gain = Points({{5.0, 1.0}, {105.0, 0.5}}),
       .time_constant = Points({{0.0, 1.0}, {1000.0, 1.0 + 1000.0 * a}})});
  AgeingPlant plant =
      MakeAgeing(SingleLoop(TransferFunction::FirstOrder(K, T, 0.0)), ageing);
  const MatrixXd y = OutputsOf(plant, MatrixXd::Ones(1, 500));
  for (int k = 0; k < 500; ++k) {
    const double t = 0.2 * k;
    const double gain = K * (1.0 - 0.005 * std::max(0.0, t - 5.0));
    const double clock = std::log1p(a * t) / a;
    ASSERT_NEAR(y(0, k), -gain * std::expm1(-clock / T), 1e-8 * K) << t;
  }
}

// L(t) = L₀ + β t: the step at 0 arrives at L₀ / (1 − β), off the grid.
TEST(AgeingPlantTest, DriftOfTheDeadTime) {
  const double K = -19.4, T = 14.4, L = 3.07, rate = 0.11;
  AgeingSchedule ageing;
  ageing.elements.push_back(
      {.delay = Points({{0.0, 0.0}, {1000.0, 1000.0 * rate}})});
  AgeingPlant plant =
      MakeAgeing(SingleLoop(TransferFunction::FirstOrder(K, T, L)), ageing);
  const double arrival = L / (1.0 - rate);
  const MatrixXd y = OutputsOf(plant, MatrixXd::Ones(1, 500));
  for (int k = 0; k < 500; ++k) {
    const double t = 0.2 * k;
    const double expected =
        t > arrival ? -K * std::expm1(-(t - arrival) / T) : 0.0;
    ASSERT_NEAR(y(0, k), expected, 1e-8 * std::abs(K)) << t;
  }
}

// At t = 30.07 the gain halves, T doubles and 4 units of dead time are added,
// under an input that stepped long before and steps again at 29: the second
// step arrives at 29 + 1 before the event, and once more 5 after it was sent.
TEST(AgeingPlantTest, AnEventIsAStep) {
  const double K = 2.0, T = 8.0, event = 30.07;
  AgeingSchedule ageing;
  ageing.elements.push_back(
      {.gain = Points({{event, 1.0}, {event, 0.5}}),
       .time_constant = Points({{event, 1.0}, {event, 2.0}}),
       .delay = Points({{event, 0.0}, {event, 4.0}})});
  AgeingPlant plant =
      MakeAgeing(SingleLoop(TransferFunction::FirstOrder(K, T, 1.0)), ageing);
  MatrixXd inputs = MatrixXd::Ones(1, 500);
  inputs.rightCols(500 - 145).setConstant(3.0);  // from t = 29 on
  const MatrixXd y = OutputsOf(plant, inputs);

  // x follows ẋ = (K w − x)/T piece by piece.
  const auto approach = [](double x, double limit, double time, double T_now) {
    return limit + (x - limit) * std::exp(-time / T_now);
  };
  const double at_30 = approach(0.0, K, 29.0, T);  // since 1
  const double at_event = approach(at_30, 3.0 * K, event - 30.0, T);
  const double at_34 = approach(at_event, K, 34.0 - event, 2.0 * T);
  for (int k = 0; k < 500; ++k) {
    const double t = 0.2 * k;
    double expected = 0.0;
    if (t > 34.0) {
      expected = 0.5 * approach(at_34, 3.0 * K, t - 34.0, 2.0 * T);
    } else if (t > event) {
      expected = 0.5 * approach(at_event, K, t - event, 2.0 * T);
    } else if (t > 30.0) {
      expected = approach(at_30, 3.0 * K, t - 30.0, T);
    } else if (t > 1.0) {
      expected = approach(0.0, K, t - 1.0, T);
    }
    ASSERT_NEAR(y(0, k), expected, 1e-8 * K) << t;
  }
}

// Upwards with T, downwards with 3 T, whatever the signs of gain and factor.
TEST(AgeingPlantTest, AnElementMayFallMoreSlowly) {
  const double T = 5.0;
  for (const auto& [gain, factor] :
       {std::pair(2.0, 1.0), std::pair(-2.0, 1.0), std::pair(2.0, -1.0)}) {
    const double K = factor * gain;
    AgeingSchedule ageing;
    ageing.elements.push_back({.gain = Schedule(factor), .falling = 3.0});
    AgeingPlant plant = MakeAgeing(
        SingleLoop(TransferFunction::FirstOrder(gain, T, 1.0)), ageing);
    MatrixXd inputs = MatrixXd::Ones(1, 500);
    inputs.rightCols(500 - 145).setZero();  // from t = 29 on
    const MatrixXd y = OutputsOf(plant, inputs);
    const double on = K > 0.0 ? T : 3.0 * T;
    const double off = K > 0.0 ? 3.0 * T : T;
    for (int k = 0; k < 500; ++k) {
      const double t = 0.2 * k;
      double expected = 0.0;
      if (t > 30.0) {
        expected = -K * std::expm1(-29.0 / on) * std::exp(-(t - 30.0) / off);
      } else if (t > 1.0) {
        expected = -K * std::expm1(-(t - 1.0) / on);
      }
      ASSERT_NEAR(y(0, k), expected, 1e-8 * std::abs(K)) << t;
    }
  }
}

// Of two elements only the one that is named; a second-order one turns where
// its own output does.
TEST(AgeingPlantTest, DirectionsAreThoseOfTheElement) {
  const ProcessModel model = MixedModel();
  AgeingSchedule ageing;
  ageing.elements.push_back({.output = 1, .input = 0, .falling = 2.0});
  AgeingPlant slower = MakeAgeing(model, ageing);
  AgeingPlant plain = MakeAgeing(model, {});
  const MatrixXd inputs = RandomInputs(3, 400);
  const MatrixXd with = OutputsOf(slower, inputs);
  const MatrixXd without = OutputsOf(plain, inputs);
  EXPECT_EQ(with.row(0), without.row(0));
  EXPECT_GT((with.row(1) - without.row(1)).norm(), 0.05 * without.norm());
}

// Elements integrated one by one, and the whole as one block-diagonal system.
TEST(AgeingPlantTest, EqualsTheGeneralLinearSystem) {
  for (const ProcessModel& model : {MixedModel(), ThreeByThree()}) {
    const AgeingSchedule ageing = AgeingOfEverything(model);
    AgeingPlant plant = MakeAgeing(model, ageing, {.start_time = 2.0});
    absl::StatusOr<ContinuousSystem> system = ToLinearSystem(model, ageing);
    ASSERT_TRUE(system.ok()) << system.status();
    absl::StatusOr<ContinuousPlant> general = ContinuousPlant::Create(
        *system, {.sample_time = 0.2, .start_time = 2.0});
    ASSERT_TRUE(general.ok()) << general.status();
    const MatrixXd inputs = RandomInputs(model.num_inputs(), 400);
    const MatrixXd expected = OutputsOf(*general, inputs);
    EXPECT_LE((OutputsOf(plant, inputs) - expected).norm(),
              1e-8 * expected.norm());
  }
}

TEST(AgeingPlantTest, OldPlantsAreTheAgedModel) {
  const ProcessModel model = ThreeByThree();
  const AgeingSchedule ageing = AgeingOfEverything(model);
  const ProcessModel aged = AgedModel(model, ageing, 5000.0);
  ASSERT_TRUE(aged.Validate().ok());
  AgeingPlant plant = MakeAgeing(model, ageing, {.start_time = 5000.0});
  absl::StatusOr<Plant> fast = Plant::Create(aged, {.sample_time = 0.2});
  ASSERT_TRUE(fast.ok()) << fast.status();
  const MatrixXd inputs = RandomInputs(3, 400);
  const MatrixXd expected = OutputsOf(*fast, inputs);
  EXPECT_LE((OutputsOf(plant, inputs) - expected).norm(),
            1e-8 * expected.norm());
}

// The slope is γ K; τ stretches the lag alone, and what has been integrated
// stays.
TEST(AgeingPlantTest, AnAgeingIntegratorKeepsItsLevel) {
  const double K = 0.5, T = 2.0;
  const ProcessModel model =
      SingleLoop(TransferFunction::Integrator(K, T, 0.0));
  const AgeingSchedule event = {
      {{.gain = Points({{40.0, 1.0}, {40.0, 0.6}}),
        .time_constant = Points({{40.0, 1.0}, {40.0, 3.0}})}}};
  AgeingPlant plant = MakeAgeing(model, event, {.sample_time = 1.0});
  const MatrixXd y = OutputsOf(plant, MatrixXd::Ones(1, 120));
  // Long before: K (t − T); long after the lag stands at its new value.
  EXPECT_NEAR(y(40), K * (40.0 - T), 1e-6);
  EXPECT_NEAR(y(41) - y(40), 0.6 * K, 1e-6);
  EXPECT_NEAR(y(110) - y(109), 0.6 * K, 1e-6);

  AgeingSchedule old = {{{.gain = Schedule(0.6),
                          .time_constant = Schedule(3.0),
                          .delay = Schedule(0.5)}}};
  const TransferFunction aged =
      AgedElement(model.element(0, 0), old.elements[0], 0.0);
  EXPECT_NEAR(aged.StaticGain(), 0.6 * K, 1e-15);
  EXPECT_NEAR(aged.SlowestTimeConstant(), 3.0 * T, 1e-14);
  AgeingPlant aged_plant = MakeAgeing(model, old, {.sample_time = 1.0});
  const MatrixXd z = OutputsOf(aged_plant, MatrixXd::Ones(1, 60));
  const VectorXd expected = aged.StepResponse(1.0, 60);
  // Of the integration, relative to a level of 20.
  EXPECT_LE((z.row(0).transpose() - expected).cwiseAbs().maxCoeff(), 1e-6);

  old.elements[0].falling = 2.0;
  EXPECT_THAT(std::string(old.Validate(model).message()),
              HasSubstr("integrates"));
}

TEST(AgeingPlantTest, WithoutAgeingItIsThePlant) {
  const ProcessModel model = MixedModel();
  AgeingPlant plant = MakeAgeing(model, {});
  absl::StatusOr<Plant> fast = Plant::Create(model, {});
  ASSERT_TRUE(fast.ok());
  const MatrixXd inputs = RandomInputs(3, 100);
  EXPECT_EQ(OutputsOf(plant, inputs), OutputsOf(*fast, inputs));
}

TEST(AgeingTest, AgedElementHasTheFactors) {
  const TransferFunction element = SecondOrder(2.0, 3.0, 4.0, 5.0, 1.0);
  const ElementAgeing ageing{.gain = Schedule(0.5),
                             .time_constant = Schedule(2.0),
                             .delay = Schedule(0.25)};
  const TransferFunction aged = AgedElement(element, ageing, 0.0);
  const TransferFunction expected = SecondOrder(1.0, 6.0, 8.0, 10.0, 1.25);
  EXPECT_EQ(aged.numerator(), expected.numerator());
  EXPECT_EQ(aged.denominator(), expected.denominator());
  EXPECT_EQ(aged.delay(), expected.delay());
}

TEST(AgeingTest, SchedulesAreChecked) {
  const auto message = [](const ElementAgeing& one) {
    return std::string(AgeingSchedule{{one}}.Validate(MixedModel()).message());
  };
  EXPECT_THAT(message({.output = 2}), HasSubstr("element (2, 0)"));
  EXPECT_THAT(message({.output = 1, .input = 2}),
              HasSubstr("element (y2, u3): is zero"));
  EXPECT_THAT(message({.time_constant = Schedule(0.0)}),
              HasSubstr("time_constant falls to 0"));
  EXPECT_THAT(message({.falling = 0.0}), HasSubstr("falling = 0"));
  EXPECT_THAT(message({.delay = Schedule(-0.7)}),
              HasSubstr("the dead time is only 0.6"));
  EXPECT_THAT(message({.delay = Points({{0.0, 0.0}, {1.0, 2.0}})}),
              HasSubstr("delay grows by 2 per unit of time"));
  EXPECT_THAT(
      std::string(AgeingSchedule{{{}, {}}}.Validate(MixedModel()).message()),
      HasSubstr("is duplicated"));
}

}  // namespace
}  // namespace mle::sim
