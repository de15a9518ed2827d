#include "sim/van_de_vusse.h"

#include <cmath>

#include "Eigen/Eigenvalues"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/steady_state.h"
#include "tests/sim/nonlinear_plants.h"

namespace mle::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;
using Eigen::VectorXd;
using ::mle::testing::ExpectLinearisedAs;
using ::mle::testing::Hold;
using ::mle::testing::MadeSystem;
using ::mle::testing::PlantOf;
using ::testing::HasSubstr;

ContinuousSystem Reactor(const VanDeVusseOptions& options = {}) {
  return MadeSystem(MakeVanDeVusseReactor(options));
}

// The operating point as published, to the digits given there.
TEST(VanDeVusseTest, SteadyStateIsThePublishedOne) {
  const VectorXd x = Reactor().initial_state;
  EXPECT_NEAR(x[0], 2.14, 0.005);
  EXPECT_NEAR(x[1], 1.09, 0.005);
  EXPECT_NEAR(x[2], 114.2, 0.05);
  EXPECT_NEAR(x[3], 112.9, 0.05);
}

TEST(VanDeVusseTest, StaysAtItsSteadyState) {
  for (const double feed : {5.0, 14.19, 25.0}) {
    ContinuousPlant plant = PlantOf(Reactor({.feed = feed}), 0.01);
    Hold(plant, Vector2d::Zero(), 200);
    // The steady state is solved for to rounding, and stable.
    EXPECT_LE(plant.outputs().cwiseAbs().maxCoeff(), 1e-9) << feed;
  }
}

TEST(VanDeVusseTest, SteadyStateIsStable) {
  const ContinuousSystem system = Reactor();
  const Eigen::MatrixXd A =
      Linearise(system.derivative, system.initial_state, system.input_origin).A;
  EXPECT_LT(A.eigenvalues().real().maxCoeff(), -10.0);
}

// Far from the steady state, against SciPy 1.10's DOP853 at tolerances of
// 1e-13: the feed raised by 3 for 0.2 h, then the cooling by 500 for 0.3 h.
TEST(VanDeVusseTest, LargeStepsAgreeWithAnEighthOrderIntegrator) {
  ContinuousPlant plant = PlantOf(Reactor(), 0.01);
  Hold(plant, Vector2d(3.0, 0.0), 20);
  const Vector4d after_feed(2.3613957533124275, 1.0847645390439327,
                            114.06961806209742, 112.77114522497854);
  // Steps of 0.02 of the fastest time constant: below 1e-8 of the change.
  EXPECT_LE((plant.state() - after_feed).cwiseAbs().maxCoeff(), 1e-8);
  Hold(plant, Vector2d(3.0, -500.0), 30);
  const Vector4d after_heat(2.435042321219903, 1.0759811779222266,
                            112.97565020033538, 111.11838669396758);
  EXPECT_LE((plant.state() - after_heat).cwiseAbs().maxCoeff(), 1e-8);
}

// More feed makes more B at low feed, less at high feed.
TEST(VanDeVusseTest, GainOfTheFeedTurnsItsSign) {
  const auto change = [](double feed) {
    ContinuousPlant plant = PlantOf(Reactor({.feed = feed}), 0.01);
    Hold(plant, Vector2d(0.1, 0.0), 300);
    return plant.outputs()[0];
  };
  EXPECT_GT(change(8.0), 1e-3);
  EXPECT_LT(change(25.0), -1e-3);
}

// From the steady state of fresh catalyst, activity falls to 0.9: it ends at
// the steady state of the spent one.
TEST(VanDeVusseTest, AgesToTheSteadyStateOfSpentCatalyst) {
  absl::StatusOr<Schedule> activity =
      Schedule::Create({{0.0, 1.0}, {2.0, 0.9}});
  ASSERT_TRUE(activity.ok());
  ContinuousPlant plant = PlantOf(Reactor({.activity = *activity}), 0.01);
  Hold(plant, Vector2d::Zero(), 500);
  const VectorXd spent = Reactor({.activity = Schedule(0.9)}).initial_state;
  EXPECT_LE((plant.state() - spent).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_GT(spent[0], 2.2);  // More A is left over.
}

// Its process model is that at a feed of 8.
TEST(VanDeVusseTest, SmallStepsAreThoseOfItsProcessModel) {
  for (const Vector2d& step : {Vector2d(0.1, 0.0), Vector2d(0.0, 20.0)}) {
    ExpectLinearisedAs("van_de_vusse.json", Reactor({.feed = 8.0}), 0.005, step,
                       5e-3);
  }
}

TEST(VanDeVusseTest, OptionsAreChecked) {
  const auto message = [](const VanDeVusseOptions& options) {
    return std::string(MakeVanDeVusseReactor(options).status().message());
  };
  EXPECT_THAT(message({.feed = 0.0}), HasSubstr("feed = 0"));
  EXPECT_THAT(message({.activity = Schedule(-1.0)}),
              HasSubstr("activity = -1"));
  EXPECT_THAT(message({.heat = std::nan("")}), HasSubstr("heat = nan"));
}

TEST(SteadyStateTest, SaysSoWhereThereIsNone) {
  const SystemFunction growth = [](double, const VectorXd& x, const VectorXd&,
                                   VectorXd& dx) { dx[0] = 1.0 + x[0] * x[0]; };
  const absl::Status status =
      SolveSteadyState(growth, VectorXd::Zero(1), VectorXd::Zero(1)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no steady state"));
}

}  // namespace
}  // namespace mle::sim
