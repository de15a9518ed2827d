#include "sim/ph_neutralisation.h"

#include <cmath>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
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

ContinuousSystem Neutralisation(const PhNeutralisationOptions& options = {}) {
  return MadeSystem(MakePhNeutralisation(options));
}

// The operating point as published, to the digits given there; 15.6 mL/s of
// base, a rounded figure, still has pH 7.0.
TEST(PhNeutralisationTest, SteadyStateIsThePublishedOne) {
  const VectorXd x = Neutralisation().initial_state;
  EXPECT_NEAR(x[0], 14.0, 0.05);
  EXPECT_NEAR(x[1], -0.432, 0.0005);
  EXPECT_NEAR(x[2], 0.528, 0.0005);
  EXPECT_NEAR(x[3], 7.0, 0.005);
  const VectorXd rounded = Neutralisation({.base = 15.6}).initial_state;
  EXPECT_NEAR(rounded[0], 14.0, 0.05);
  EXPECT_NEAR(rounded[3], 7.0, 0.05);
}

// Concentrations of all ions at a pH, from the constants of equilibrium, have
// the invariants of which that pH is the solution.
TEST(PhNeutralisationTest, PhIsThatOfTheIons) {
  const double K1 = std::pow(10.0, -6.35);
  const double K2 = std::pow(10.0, -10.25);
  for (const double carbonate : {0.0, 0.05, 0.528, 30.0}) {
    for (double ph = 1.0; ph <= 13.0; ph += 0.37) {
      const double hydrogen = std::pow(10.0, -ph);
      const double bicarbonate =
          carbonate / (hydrogen / K1 + 1.0 + K2 / hydrogen);
      const double wa = 1e3 * (hydrogen - 1e-14 / hydrogen) - bicarbonate -
                        2.0 * bicarbonate * K2 / hydrogen;
      EXPECT_NEAR(PhOfInvariants(wa, carbonate), ph, 1e-8)
          << carbonate << " mmol/L";
    }
  }
}

// pH at rest over the base flow, against Brent's method on the balance of the
// ions (SciPy 1.10).
TEST(PhNeutralisationTest, TitrationCurve) {
  for (const auto& [base, ph] :
       {std::pair(5.0, 3.0886758953433087), std::pair(10.0, 3.975661265638441),
        std::pair(13.0, 6.121695380622016), std::pair(15.0, 6.763737624921258),
        std::pair(16.0, 7.278946206268665), std::pair(17.0, 8.9907318966062),
        std::pair(18.0, 9.55813136424043),
        std::pair(25.0, 10.51260079049647)}) {
    EXPECT_NEAR(Neutralisation({.base = base}).initial_state[3], ph, 1e-9);
  }
}

TEST(PhNeutralisationTest, StaysAtItsSteadyState) {
  for (const double base : {5.0, 15.55, 25.0}) {
    ContinuousPlant plant = PlantOf(Neutralisation({.base = base}), 3.0);
    Hold(plant, Vector2d::Zero(), 300);
    EXPECT_LE(plant.outputs().cwiseAbs().maxCoeff(), 1e-9) << base;
  }
}

// Of volume and of both invariants: what is in the tank changes by what the
// streams bring less what leaves.
TEST(PhNeutralisationTest, MassesAreKept) {
  constexpr double kArea = 207.0;
  const Vector4d x(9.0, 0.7, 0.3, 5.0);
  const Vector2d w(20.0, 11.0);
  const VectorXd dx = DerivativeOf(Neutralisation(), x, w);
  const double out = 8.75 * std::sqrt(x[0]);
  EXPECT_NEAR(kArea * dx[0], w[0] + 0.55 + w[1] - out, 1e-12);
  const auto change = [&](int i) {
    return kArea * (dx[0] * x[i] + x[0] * dx[i]);
  };
  EXPECT_NEAR(change(1), 3.0 * w[0] - 30.0 * 0.55 - 3.05 * w[1] - out * x[1],
              1e-11);
  EXPECT_NEAR(change(2), 30.0 * 0.55 + 0.05 * w[1] - out * x[2], 1e-11);
}

// Against SciPy 1.10's DOP853 at tolerances of 1e-13: 1.5 mL/s less base for
// 60 s, then 2 mL/s more acid for 90 s.
TEST(PhNeutralisationTest, LargeStepsAgreeWithAnEighthOrderIntegrator) {
  ContinuousPlant plant = PlantOf(Neutralisation(), 3.0);
  Hold(plant, Vector2d(0.0, -1.5), 20);
  const Vector4d after_base(13.597816427325146, -0.3714366422362909,
                            0.5394364083032306, 6.750990233252575);
  EXPECT_LE((plant.state() - after_base).cwiseAbs().maxCoeff(), 1e-8);
  Hold(plant, Vector2d(2.0, -1.5), 30);
  const Vector4d after_acid(13.915448479842249, -0.1996945568886877,
                            0.5256099294801443, 6.203019549871507);
  EXPECT_LE((plant.state() - after_acid).cwiseAbs().maxCoeff(), 1e-8);
}

// Without acid and base only the buffer flows through.
TEST(PhNeutralisationTest, RunsDownToTheBufferAndFillsAgain) {
  ContinuousPlant plant = PlantOf(Neutralisation(), 3.0);
  const VectorXd full = plant.state();
  Hold(plant, Vector2d(-50.0, -50.0), 1000);
  EXPECT_NEAR(plant.state()[0], std::pow(0.55 / 8.75, 2), 1e-6);
  EXPECT_NEAR(plant.state()[1], -30.0, 1e-6);
  EXPECT_NEAR(plant.state()[2], 30.0, 1e-6);
  Hold(plant, Vector2d::Zero(), 1500);
  EXPECT_LE((plant.state() - full).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(PhNeutralisationTest, SmallStepsAreThoseOfItsProcessModel) {
  for (const Vector2d& step : {Vector2d(0.05, 0.0), Vector2d(0.0, 0.05)}) {
    ExpectLinearisedAs("ph_neutralisation.json", Neutralisation(), 6.0, step,
                       2e-3);
  }
}

TEST(PhNeutralisationTest, AgesToTheSteadyStateOfTheAgedPlant) {
  const PhNeutralisationOptions aged{.acid_factor = Schedule(0.97),
                                     .buffer_factor = Schedule(0.8),
                                     .slope_factor = Schedule(0.9),
                                     .lag_factor = Schedule(2.0)};
  PhNeutralisationOptions ages = aged;
  for (const AgeingFactor& ageing : AgeingFactors(ages)) {
    *ageing.factor =
        *Schedule::Create({{0.0, 1.0}, {500.0, ageing.factor->At(0.0)}});
  }
  ContinuousPlant plant = PlantOf(Neutralisation(ages), 3.0);
  Hold(plant, Vector2d::Zero(), 1500);
  const VectorXd end = Neutralisation(aged).initial_state;
  EXPECT_LE((plant.state() - end).cwiseAbs().maxCoeff(), 1e-7);
  // A worn electrode shows less of what is far from neutral.
  EXPECT_NEAR(end[3] - 7.0, 0.9 * (PhOfInvariants(end[1], end[2]) - 7.0),
              1e-12);
  EXPECT_GT(std::abs(end[3] - 7.0), 0.1);
}

TEST(PhNeutralisationTest, OptionsAreChecked) {
  const auto message = [](const PhNeutralisationOptions& options) {
    return std::string(MakePhNeutralisation(options).status().message());
  };
  EXPECT_THAT(message({.acid = 0.0}), HasSubstr("acid = 0"));
  EXPECT_THAT(message({.base = std::nan("")}), HasSubstr("base = nan"));
  EXPECT_THAT(message({.buffer = -1.0}), HasSubstr("buffer = -1"));
  EXPECT_THAT(message({.electrode_lag = 0.0}), HasSubstr("electrode_lag = 0"));
  EXPECT_THAT(message({.slope_factor = Schedule(-1.0)}),
              HasSubstr("electrode_slope = -1"));
}

}  // namespace
}  // namespace mle::sim
