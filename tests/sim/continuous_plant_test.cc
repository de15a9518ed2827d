#include "sim/continuous_plant.h"

#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/linear_system.h"

namespace mle::sim {
namespace {

using Eigen::VectorXd;
using ::testing::HasSubstr;

VectorXd One(double value) { return VectorXd::Constant(1, value); }

// ẋ = f(t, x, w), y = x.
ContinuousSystem Scalar(
    const std::function<double(double t, double x, double w)>& f) {
  ContinuousSystem system;
  system.num_inputs = system.num_outputs = 1;
  system.derivative = [f](double t, const VectorXd& x, const VectorXd& w,
                          VectorXd& dx) { dx[0] = f(t, x[0], w[0]); };
  system.output = [](double, const VectorXd& x, const VectorXd&, VectorXd& y) {
    y = x;
  };
  system.initial_state = One(1.0);
  system.largest_step = 0.01;
  return system;
}

ContinuousPlant MakeContinuous(const ContinuousSystem& system,
                               const ContinuousPlantOptions& options = {}) {
  absl::StatusOr<ContinuousPlant> plant =
      ContinuousPlant::Create(system, options);
  EXPECT_TRUE(plant.ok()) << plant.status();
  return *std::move(plant);
}

// ẋ = −(1 + sin t) x, x(0) = 1: x = exp(−t − 1 + cos t).
TEST(ContinuousPlantTest, CoefficientsMayVarySmoothly) {
  ContinuousPlant plant = MakeContinuous(Scalar(
      [](double t, double x, double) { return -(1.0 + std::sin(t)) * x; }));
  for (int k = 1; k <= 50; ++k) {
    plant.Advance(One(0.0));
    const double t = 0.2 * k;
    const double expected = std::exp(-t - 1.0 + std::cos(t));
    // (h |λ|)⁴ / 120 for each unit of t, with |λ| ≤ 2: 1e-9 and some growth.
    ASSERT_NEAR(plant.outputs()[0] / expected, 1.0, 2e-8) << t;
  }
}

TEST(ContinuousPlantTest, ConvergesWithOrderFour) {
  const auto error = [](double step) {
    ContinuousSystem system = Scalar(
        [](double t, double x, double) { return -(1.0 + std::sin(t)) * x; });
    system.largest_step = step;
    ContinuousPlant plant = MakeContinuous(system);
    for (int k = 0; k < 20; ++k) plant.Advance(One(0.0));
    return std::abs(plant.outputs()[0] - std::exp(-5.0 + std::cos(4.0)));
  };
  // Halving the step divides the error by 16, but for the next order.
  EXPECT_NEAR(error(0.1) / error(0.05), 16.0, 2.0);
  EXPECT_NEAR(error(0.05) / error(0.025), 16.0, 1.0);
}

// ẋ = −r(t) x with a jump of r inside a sample, not on any step.
TEST(ContinuousPlantTest, NoStepCrossesABreak) {
  const double jump = 1.2345;
  ContinuousSystem system = Scalar(
      [jump](double t, double x, double) { return t < jump ? -x : -0.25 * x; });
  system.breaks = {jump};
  ContinuousPlant plant = MakeContinuous(system);
  for (int k = 0; k < 20; ++k) plant.Advance(One(0.0));
  EXPECT_NEAR(plant.outputs()[0],
              std::exp(-jump) * std::exp(-0.25 * (4.0 - jump)), 1e-9);
}

// The same where the jump is on a sample, whose time is not exact in binary.
TEST(ContinuousPlantTest, ABreakOnASampleActsFromThereOn) {
  const double jump = 0.6;
  ContinuousSystem system = Scalar(
      [jump](double t, double x, double) { return t < jump ? -x : -0.25 * x; });
  system.breaks = {jump};
  ContinuousPlant plant = MakeContinuous(system);
  for (int k = 0; k < 10; ++k) plant.Advance(One(0.0));
  EXPECT_NEAR(plant.outputs()[0],
              std::exp(-jump) * std::exp(-0.25 * (2.0 - jump)), 1e-9);
}

TEST(ContinuousPlantTest, StartTimeShiftsTheClock) {
  ContinuousPlant plant =
      MakeContinuous(Scalar([](double t, double, double) { return 2.0 * t; }),
                     {.sample_time = 0.5, .start_time = 100.0});
  plant.Advance(One(0.0));
  plant.Advance(One(0.0));
  EXPECT_EQ(plant.time(), 101.0);
  EXPECT_NEAR(plant.outputs()[0], 1.0 + 101.0 * 101.0 - 100.0 * 100.0, 1e-9);
}

// A tank, ẋ = u − ½√x, at rest at x = 4 under u = 1.
TEST(ContinuousPlantTest, InputsAndOutputsAreDeviations) {
  ContinuousSystem system =
      Scalar([](double, double x, double w) { return w - 0.5 * std::sqrt(x); });
  system.initial_state = One(4.0);
  system.input_origin = One(1.0);
  system.output_origin = One(4.0);
  ContinuousPlant plant = MakeContinuous(system);
  EXPECT_EQ(plant.outputs()[0], 0.0);
  for (int k = 0; k < 100; ++k) plant.Advance(One(0.0));
  EXPECT_NEAR(plant.outputs()[0], 0.0, 1e-13);
  for (int k = 0; k < 5000; ++k) plant.Advance(One(0.5));
  EXPECT_NEAR(plant.outputs()[0], 9.0 - 4.0, 1e-9);  // ½√x = 1.5
}

// One input that acts at once and again, in the opposite sense, after 1.3.
TEST(ContinuousPlantTest, AnInputMayActThroughSeveralDeadTimes) {
  LinearCoefficients c;
  c.A = Eigen::MatrixXd::Constant(1, 1, -0.5);
  c.B = Eigen::RowVector2d(1.0, -2.0);
  c.C = Eigen::MatrixXd::Ones(1, 1);
  c.D = Eigen::RowVector2d(0.0, 0.0);
  absl::StatusOr<ContinuousSystem> system =
      MakeLinearSystem(c, 1, {{0, Schedule(0.0)}, {0, Schedule(1.3)}});
  ASSERT_TRUE(system.ok()) << system.status();
  ContinuousPlant plant = MakeContinuous(*system);
  for (int k = 1; k <= 40; ++k) {
    plant.Advance(One(1.0));
    const double t = 0.2 * k;
    double expected = -2.0 * std::expm1(-0.5 * t);
    if (t > 1.3) expected += 4.0 * std::expm1(-0.5 * (t - 1.3));
    ASSERT_NEAR(plant.outputs()[0], expected, 1e-9) << t;
  }
}

// ẋ = x² ends in finite time.
TEST(ContinuousPlantTest, APlantThatBlowsUpIsNotFinite) {
  ContinuousPlant plant =
      MakeContinuous(Scalar([](double, double x, double) { return x * x; }));
  for (int k = 0; k < 20; ++k) plant.Advance(One(0.0));
  EXPECT_FALSE(plant.outputs().allFinite());
}

TEST(ContinuousPlantTest, SystemsAreChecked) {
  const auto message = [](const auto& spoil) {
    ContinuousSystem system =
        Scalar([](double, double x, double) { return -x; });
    spoil(system);
    return std::string(ContinuousPlant::Create(system, {}).status().message());
  };
  EXPECT_THAT(message([](auto& s) { s.num_inputs = 0; }),
              HasSubstr("num_inputs = 0"));
  EXPECT_THAT(message([](auto& s) { s.largest_step = 0.0; }),
              HasSubstr("largest_step = 0"));
  EXPECT_THAT(message([](auto& s) { s.largest_step = 1e-12; }),
              HasSubstr("too fine"));
  EXPECT_THAT(message([](auto& s) { s.output = nullptr; }),
              HasSubstr("must both be given"));
  EXPECT_THAT(message([](auto& s) { s.input_origin = VectorXd::Zero(3); }),
              HasSubstr("input_origin has 3 values"));
  EXPECT_THAT(message([](auto& s) {
                s.paths = {{1, Schedule(0.0)}};
              }),
              HasSubstr("path 1: input = 1"));
  EXPECT_THAT(message([](auto& s) {
                s.initial_state[0] = std::numeric_limits<double>::quiet_NaN();
              }),
              HasSubstr("initial_state"));
}

}  // namespace
}  // namespace mle::sim
