#include "sim/sensor.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using ::testing::HasSubstr;

// Of a ramp t from rest: t − T (1 − e^{−t/T}), whatever the sample time.
TEST(LagTest, FollowsARampExactly) {
  const double time_constant = 1.7;
  for (const double sample_time : {0.01, 0.5, 20.0}) {
    Lag lag(time_constant, sample_time);
    for (int k = 0; k < 50; ++k) {
      const double t = k * sample_time;
      EXPECT_NEAR(lag.Follow(t),
                  t + time_constant * std::expm1(-t / time_constant), 1e-10);
    }
  }
}

TEST(LagTest, StartsSteadyAndSettles) {
  Lag lag(3.0, 1.0);
  EXPECT_EQ(lag.Follow(5.0), 5.0);
  EXPECT_NEAR(lag.Follow(5.0), 5.0, 1e-12);
  for (int k = 0; k < 100; ++k) lag.Follow(-2.0);
  EXPECT_NEAR(lag.Follow(-2.0), -2.0, 1e-12);
}

TEST(LagTest, WithoutALagItIsTheSignal) {
  Lag lag(0.0, 1.0);
  for (const double value : {1.0, -3.0, 0.5}) {
    EXPECT_EQ(lag.Follow(value), value);
  }
}

TEST(SensorsTest, OnlyTheirOutputIsLagged) {
  Sensors sensors({{.output = 1, .lag = 2.0}}, 0.5);
  MatrixXd whole = MatrixXd::Random(2, 20);
  MatrixXd one_by_one = whole;
  for (int k = 0; k < 20; ++k) sensors.Follow(one_by_one.col(k));
  const MatrixXd before = whole;
  sensors.FollowAll(whole);
  EXPECT_EQ(whole, one_by_one);
  EXPECT_EQ(whole.row(0), before.row(0));
  Lag lag(2.0, 0.5);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(whole(1, k), lag.Follow(before(1, k)));
}

// φ(0) = 0, φ'(0) = 1, and what defines each curve.
TEST(SensorsTest, CurvesHaveTheSlopeOneAtTheOperatingPoint) {
  const double a = 0.4;
  const auto shown = [a](OutputCurve curve, double value) {
    VectorXd outputs = VectorXd::Constant(1, value);
    Sensors({{.curve = curve, .curvature = a}}, 1.0).Follow(outputs);
    return outputs[0];
  };
  for (const OutputCurve curve :
       {OutputCurve::kNone, OutputCurve::kQuadratic, OutputCurve::kLogarithm,
        OutputCurve::kTanh}) {
    EXPECT_EQ(shown(curve, 0.0), 0.0);
    EXPECT_NEAR((shown(curve, 1e-5) - shown(curve, -1e-5)) / 2e-5, 1.0, 1e-8);
  }
  using enum OutputCurve;
  EXPECT_EQ(shown(kNone, 1.5), 1.5);
  // The same bend both ways; a logarithm is the inverse of an exponential; an S
  // is odd and ends at 1/a.
  EXPECT_NEAR(shown(kQuadratic, 1.5) + shown(kQuadratic, -1.5), 2 * a * 2.25,
              1e-12);
  EXPECT_NEAR(std::exp(a * shown(kLogarithm, 1.5)), 1.0 + a * 1.5, 1e-12);
  EXPECT_NEAR(shown(kTanh, 1.5), -shown(kTanh, -1.5), 1e-12);
  EXPECT_NEAR(shown(kTanh, 100.0), 1.0 / a, 1e-12);
  EXPECT_TRUE(std::isfinite(shown(kLogarithm, -100.0)));
  EXPECT_LT(shown(kLogarithm, -100.0), shown(kLogarithm, -1.5));
}

TEST(SensorsTest, ABentSensorIsBentBeforeItLags) {
  Sensors sensors(
      {{.curve = OutputCurve::kQuadratic, .curvature = 0.3, .lag = 2.0}}, 0.5);
  Lag lag(2.0, 0.5);
  for (const double value : {0.0, 1.0, 2.0, -1.0, -1.0}) {
    VectorXd outputs = VectorXd::Constant(1, value);
    sensors.Follow(outputs);
    EXPECT_NEAR(outputs[0], lag.Follow(value + 0.3 * value * value), 1e-12);
  }
}

TEST(SensorsTest, ADeadSensorRepeatsWhatItShowedLast) {
  Sensors sensors({{.output = 0, .max = 2.5, .dead_from = 3.0}}, 1.0);
  VectorXd shown(6);
  for (int k = 0; k < 6; ++k) {
    VectorXd outputs = Vector2d(1.2 * k, k);
    sensors.Show(k, outputs);
    shown[k] = outputs[0];
    EXPECT_EQ(outputs[1], k);
  }
  const VectorXd expected{{0.0, 1.2, 2.4, 2.4, 2.4, 2.4}};
  EXPECT_EQ(shown, expected);
}

TEST(SensorsTest, ASensorStaysInItsRange) {
  Sensors sensors({{.output = 0, .min = -1.0, .max = 2.0}}, 1.0);
  for (const auto& [value, shown] :
       {std::pair(-3.0, -1.0), std::pair(0.5, 0.5), std::pair(9.0, 2.0)}) {
    VectorXd outputs = VectorXd::Constant(1, value);
    sensors.Show(0.0, outputs);
    EXPECT_EQ(outputs[0], shown);
  }
}

TEST(SensorsTest, OptionsAreChecked) {
  const auto message = [](const SensorOptions& options) {
    return std::string(options.Validate(2).message());
  };
  EXPECT_TRUE(SensorOptions{}.Validate(1).ok());
  EXPECT_THAT(message({.output = 2}), HasSubstr("output = 2"));
  EXPECT_THAT(message({.curvature = INFINITY}), HasSubstr("curvature = inf"));
  EXPECT_THAT(message({.lag = -1.0}), HasSubstr("lag = -1"));
  EXPECT_THAT(message({.noise_variance = -1.0}),
              HasSubstr("noise_variance = -1"));
  EXPECT_THAT(message({.min = 2.0, .max = 1.0}), HasSubstr("max = 1"));
  EXPECT_THAT(message({.dead_from = NAN}), HasSubstr("dead_from"));
}

}  // namespace
}  // namespace mle::sim
