#include "sim/quadruple_tank.h"

#include <cmath>
#include <string>
#include <vector>

#include "Eigen/LU"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "sim/steady_state.h"
#include "tests/sim/nonlinear_plants.h"

namespace mle::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;
using Eigen::VectorXd;
using ::mle::testing::DerivativeOf;
using ::mle::testing::ExpectLinearisedAs;
using ::mle::testing::Hold;
using ::mle::testing::MadeSystem;
using ::mle::testing::PlantOf;
using ::testing::HasSubstr;

ContinuousSystem Tanks(const QuadrupleTankOptions& options = {}) {
  return MadeSystem(MakeQuadrupleTank(options));
}

QuadrupleTankOptions NonMinimumPhase() {
  return {.voltage1 = 3.15,
          .voltage2 = 3.15,
          .pump1 = 3.14,
          .pump2 = 3.29,
          .split1 = 0.43,
          .split2 = 0.34};
}

// Measured on the process, to about 2 mm.
TEST(QuadrupleTankTest, SteadyStatesAreThePublishedOnes) {
  const Vector4d minimum(12.4, 12.7, 1.8, 1.4);
  EXPECT_LE((Tanks().initial_state - minimum).cwiseAbs().maxCoeff(), 0.2);
  const Vector4d other(12.6, 13.0, 4.8, 4.9);
  EXPECT_LE(
      (Tanks(NonMinimumPhase()).initial_state - other).cwiseAbs().maxCoeff(),
      0.25);
}

// G of the publication at P−, in volts of the sensor by volts of the pump: 2.6
// / (1 + 62 s), 1.5 / ((1 + 23 s)(1 + 62 s)), 1.4 / ((1 + 30 s)(1 + 90 s)) and
// 2.8 / (1 + 90 s).
TEST(QuadrupleTankTest, LinearModelIsThePublishedOne) {
  const absl::StatusOr<ProcessModel> model =
      ReadProcessModel(MLE_CONFIGS_FOLDER "/quadruple_tank.json");
  ASSERT_TRUE(model.ok()) << model.status();
  constexpr double kSensor = 0.50;  // [V/cm]
  const double T[4] = {62.0, 90.0, 23.0, 30.0};
  const auto expect = [&](int i, int j, double gain,
                          const std::vector<double>& denominator) {
    const TransferFunction& element = model->element(i, j);
    EXPECT_NEAR(kSensor * element.StaticGain(), gain, 0.06) << i << j;
    const std::vector<double>& found = element.denominator();
    ASSERT_EQ(found.size(), denominator.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_NEAR(found[k] / found.back(), denominator[k],
                  0.02 * denominator[k]);
    }
  };
  expect(0, 0, 2.6, {T[0], 1.0});
  expect(0, 1, 1.5, {T[2] * T[0], T[2] + T[0], 1.0});
  expect(1, 0, 1.4, {T[3] * T[1], T[3] + T[1], 1.0});
  expect(1, 1, 2.8, {T[1], 1.0});
}

// One zero of the plant is right of the axis at P+, none at P−: published as
// −0.060, −0.018 and 0.013, −0.057. They are where the determinant of
//   [s I − A, −B; C, 0]  vanishes.
TEST(QuadrupleTankTest, ZerosAreThePublishedOnes) {
  const auto determinant = [](const QuadrupleTankOptions& options, double s) {
    const ContinuousSystem system = Tanks(options);
    const Linearisation linear =
        Linearise(system.derivative, system.initial_state, system.input_origin);
    Eigen::Matrix<double, 6, 6> pencil = Eigen::Matrix<double, 6, 6>::Zero();
    pencil.topLeftCorner<4, 4>() = s * Eigen::Matrix4d::Identity() - linear.A;
    pencil.topRightCorner<4, 2>() = -linear.B;
    pencil.bottomLeftCorner<2, 2>().setIdentity();
    return pencil.determinant();
  };
  const auto one_between = [&](const QuadrupleTankOptions& options, double low,
                               double high) {
    return determinant(options, low) * determinant(options, high) < 0.0;
  };
  EXPECT_TRUE(one_between({}, -0.064, -0.056));
  EXPECT_TRUE(one_between({}, -0.020, -0.016));
  EXPECT_TRUE(one_between(NonMinimumPhase(), 0.011, 0.015));
  EXPECT_TRUE(one_between(NonMinimumPhase(), -0.060, -0.053));
}

TEST(QuadrupleTankTest, StaysAtItsSteadyState) {
  for (const double voltage : {0.5, 3.0, 6.0}) {
    ContinuousPlant plant = PlantOf(Tanks({.voltage1 = voltage}), 2.0);
    Hold(plant, Vector2d::Zero(), 300);
    EXPECT_LE(plant.outputs().cwiseAbs().maxCoeff(), 1e-9) << voltage;
  }
}

// What the tanks gain is what the pumps lift less what leaves the lower two.
TEST(QuadrupleTankTest, WaterIsKept) {
  const Vector4d areas(28.0, 32.0, 28.0, 32.0);
  for (const Vector4d& levels :
       {Vector4d(3.0, 9.0, 0.5, 7.0), Vector4d(18.0, 1.0, 4.0, 0.0)}) {
    const Vector2d voltages(2.0, 5.0);
    const double lifted = 3.33 * voltages[0] + 3.35 * voltages[1];
    const double leaves = 0.071 * std::sqrt(2.0 * 981.0 * levels[0]) +
                          0.057 * std::sqrt(2.0 * 981.0 * levels[1]);
    EXPECT_NEAR(areas.dot(DerivativeOf(Tanks(), levels, voltages)),
                lifted - leaves, 1e-12);
  }
}

// Against SciPy 1.10's DOP853 at tolerances of 1e-13: a pump 1 V up for 60 s,
// then the other 1.5 V down for 90 s.
TEST(QuadrupleTankTest, LargeStepsAgreeWithAnEighthOrderIntegrator) {
  ContinuousPlant plant = PlantOf(Tanks(), 2.0);
  Hold(plant, Vector2d(1.0, 0.0), 30);
  const Vector4d after_first(15.531368126853993, 13.57271995326485,
                             1.6339411322567794, 2.2813523486376974);
  EXPECT_LE((plant.state() - after_first).cwiseAbs().maxCoeff(), 1e-7);
  Hold(plant, Vector2d(1.0, -1.5), 45);
  const Vector4d after_both(14.047060379473074, 9.446817399492437,
                            0.40930153494392446, 2.4817164378467282);
  EXPECT_LE((plant.state() - after_both).cwiseAbs().maxCoeff(), 1e-7);
}

// Without power the tanks run empty and stay so.
TEST(QuadrupleTankTest, RunsEmptyAndFillsAgain) {
  ContinuousPlant plant = PlantOf(Tanks(), 2.0);
  const VectorXd full = plant.state();
  Hold(plant, Vector2d(-5.0, -5.0), 1000);
  EXPECT_LE(plant.state().cwiseAbs().maxCoeff(), 1e-2);
  Hold(plant, Vector2d::Zero(), 1000);
  EXPECT_LE((plant.state() - full).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(QuadrupleTankTest, SmallStepsAreThoseOfItsProcessModel) {
  for (const Vector2d& step : {Vector2d(0.05, 0.0), Vector2d(0.0, 0.05)}) {
    ExpectLinearisedAs("quadruple_tank.json", Tanks(), 4.0, step, 2e-3);
  }
}

// Outlets that foul hold the levels higher; a pump that wears is as much less
// voltage.
TEST(QuadrupleTankTest, AgesToTheSteadyStateOfTheAgedPlant) {
  const QuadrupleTankOptions aged{.pump1_factor = Schedule(0.9),
                                  .split2_factor = Schedule(1.1),
                                  .outlet1_factor = Schedule(0.8)};
  QuadrupleTankOptions ages = aged;
  for (const AgeingFactor& ageing : AgeingFactors(ages)) {
    *ageing.factor =
        *Schedule::Create({{0.0, 1.0}, {500.0, ageing.factor->At(0.0)}});
  }
  ContinuousPlant plant = PlantOf(Tanks(ages), 2.0);
  Hold(plant, Vector2d::Zero(), 1500);
  const VectorXd end = Tanks(aged).initial_state;
  EXPECT_LE((plant.state() - end).cwiseAbs().maxCoeff(), 1e-7);
  const VectorXd weaker = Tanks({.voltage1 = 2.7,
                                 .split2_factor = Schedule(1.1),
                                 .outlet1_factor = Schedule(0.8)})
                              .initial_state;
  EXPECT_LE((weaker - end).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(end[0], 1.2 * Tanks().initial_state[0]);
}

TEST(QuadrupleTankTest, OptionsAreChecked) {
  const auto message = [](const QuadrupleTankOptions& options) {
    return std::string(MakeQuadrupleTank(options).status().message());
  };
  EXPECT_THAT(message({.voltage2 = 0.0}), HasSubstr("voltage2 = 0"));
  EXPECT_THAT(message({.pump1 = std::nan("")}), HasSubstr("pump1 = nan"));
  EXPECT_THAT(message({.split1 = 1.0}), HasSubstr("split1 = 1 "));
  EXPECT_THAT(message({.split2_factor = Schedule(1.8)}),
              HasSubstr("split2 = 0.6 becomes 1.08"));
  EXPECT_THAT(message({.outlet4_factor = Schedule(0.0)}),
              HasSubstr("outlet4 = 0"));
}

}  // namespace
}  // namespace mle::sim
