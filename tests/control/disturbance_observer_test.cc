#include "control/disturbance_observer.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"

namespace mle::control {
namespace {

using Eigen::VectorXd;

// e_l = w_l − ŵ_l = (1 − g)(e_{l−1} + ξ) − g v, so that with r = 1 the variance
// of a filter of fixed gain g settles at
// V = ((1 − g)² ρ + g²) / (1 − (1 − g)²).
double SteadyErrorVariance(double gain, double ratio) {
  const double left = (1.0 - gain) * (1.0 - gain);
  return (left * ratio + gain * gain) / (1.0 - left);
}

TEST(StationaryGainTest, PublishedValue) {
  EXPECT_NEAR(StationaryGain(0.1), 0.2702, 5e-5);
}

TEST(StationaryGainTest, SolvesTheRiccatiEquation) {
  for (const double ratio : {1e-12, 1e-4, 0.1, 1.0, 30.0, 1e8}) {
    const double g = StationaryGain(ratio);
    // P/r = g/(1 − g) in P = P − P²/(P + r) + ρ r gives g²/(1 − g) = ρ. Near
    // g = 1 the difference 1 − g ≈ 1/ρ loses digits: 1e8 · 1e-16.
    EXPECT_NEAR(g * g / (1.0 - g), ratio, 1e-7 * ratio) << ratio;
  }
}

TEST(StationaryGainTest, IsTheLimitOfTheRiccatiRecursion) {
  for (const double ratio : {0.01, 0.1, 1.0, 10.0}) {
    for (const double start : {0.0, 100.0}) {
      double P = start;
      for (int l = 0; l < 2000; ++l) P += ratio - P * P / (P + 1.0);
      EXPECT_NEAR(P / (P + 1.0), StationaryGain(ratio), 1e-12);
    }
  }
}

TEST(StationaryGainTest, NoOtherFixedGainHasASmallerErrorVariance) {
  for (const double ratio : {0.01, 0.1, 1.0, 10.0}) {
    const double best = StationaryGain(ratio);
    const double variance = SteadyErrorVariance(best, ratio);
    for (double g = 0.01; g < 1.0; g += 0.01) {
      EXPECT_GE(SteadyErrorVariance(g, ratio), variance) << g;
    }
    // The a-posteriori variance of the filter is g r.
    EXPECT_NEAR(variance, best, 1e-12);
  }
}

TEST(StationaryGainTest, Limits) {
  EXPECT_EQ(StationaryGain(0.0), 0.0);
  EXPECT_EQ(StationaryGain(std::numeric_limits<double>::infinity()), 1.0);
  EXPECT_GT(StationaryGain(1e-300), 0.0);
  EXPECT_EQ(StationaryGain(1e300), 1.0);
  double previous = 0.0;
  for (double ratio = 1e-6; ratio < 1e6; ratio *= 3.0) {
    EXPECT_GT(StationaryGain(ratio), previous);
    previous = StationaryGain(ratio);
  }
}

TEST(DisturbanceObserverTest, StartsWithoutADisturbance) {
  const DisturbanceObserver observer(VectorXd::Constant(3, 0.1));
  EXPECT_EQ(observer.disturbance(), VectorXd::Zero(3));
  EXPECT_EQ(observer.gains(), VectorXd::Constant(3, StationaryGain(0.1)));
}

// From rest under a constant difference z: ŵ_l = (1 − (1 − g)^l) z.
TEST(DisturbanceObserverTest, ApproachesAConstantDisturbanceGeometrically) {
  DisturbanceObserver observer(VectorXd::Constant(2, 0.1));
  const VectorXd predicted = (VectorXd(2) << 4.0, -1.0).finished();
  const VectorXd w = (VectorXd(2) << 2.0, -3.0).finished();
  for (int l = 1; l <= 100; ++l) {
    observer.Update(predicted + w, predicted);
    const double share = 1.0 - std::pow(1.0 - observer.gains()[0], l);
    ASSERT_LE((observer.disturbance() - share * w).cwiseAbs().maxCoeff(),
              1e-14);
  }
}

TEST(DisturbanceObserverTest, WithInfiniteRatioIsThePlainBiasUpdate) {
  DisturbanceObserver observer(
      VectorXd::Constant(1, std::numeric_limits<double>::infinity()));
  observer.Update(VectorXd::Constant(1, 5.0), VectorXd::Constant(1, 2.0));
  EXPECT_EQ(observer.disturbance()[0], 3.0);
  observer.Update(VectorXd::Constant(1, 1.0), VectorXd::Constant(1, 2.0));
  EXPECT_EQ(observer.disturbance()[0], -1.0);
}

// A random walk with this gain, and a component that decays.
DisturbanceForm WalkAndDecay() {
  DisturbanceForm form;
  form.A = Eigen::Vector2d(1.0, 0.8).asDiagonal();
  form.C = Eigen::RowVector2d(1.0, 1.0);
  form.K = Eigen::Vector2d(0.1, 0.4);
  form.Q = Eigen::Matrix2d::Identity();
  form.R = VectorXd::Ones(1);
  return form;
}

TEST(DisturbanceModelTest, AWalkIsTheBiasFilter) {
  DisturbanceForm walk;
  walk.A = walk.C = walk.Q = Eigen::MatrixXd::Ones(1, 1);
  walk.K = Eigen::MatrixXd::Constant(1, 1, StationaryGain(0.1));
  walk.R = VectorXd::Ones(1);
  DisturbanceObserver modelled(walk, 5);
  DisturbanceObserver bias(VectorXd::Constant(1, 0.1));
  for (const double measured : {1.0, -2.0, 0.5, 7.0}) {
    const VectorXd y = VectorXd::Constant(1, measured);
    for (DisturbanceObserver* const observer : {&modelled, &bias}) {
      observer->Update(y, VectorXd::Zero(1));
      observer->Advance();
    }
    EXPECT_NEAR(modelled.disturbance()[0], bias.disturbance()[0], 1e-15);
    VectorXd one = VectorXd::Zero(1);
    VectorXd other = VectorXd::Zero(1);
    modelled.AddForecast(3, one);
    bias.AddForecast(3, other);
    EXPECT_NEAR(one[0], other[0], 1e-15);
  }
}

// d̂ ← A d̂ + K e, forecasts C A^{i−1} d̂.
TEST(DisturbanceModelTest, ForecastsDecayAsTheModelSays) {
  DisturbanceObserver observer(WalkAndDecay(), 4);
  observer.Update(VectorXd::Constant(1, 5.0), VectorXd::Constant(1, 3.0));
  for (int i = 1; i <= 4; ++i) {
    VectorXd outputs = VectorXd::Constant(1, 10.0);
    observer.AddForecast(i, outputs);
    EXPECT_NEAR(outputs[0], 10.0 + 2.0 * (0.1 + 0.4 * std::pow(0.8, i - 1)),
                1e-14);
  }
  // A measurement that is missing leaves the state to the model.
  observer.Advance();
  observer.Update(VectorXd::Constant(1, std::nan("")), VectorXd::Zero(1));
  observer.Advance();
  EXPECT_NEAR(observer.disturbance()[0], 2.0 * (0.1 + 0.4 * 0.8), 1e-14);
}

TEST(DisturbanceModelTest, RestartsAtTheStateThatStays) {
  DisturbanceObserver observer(WalkAndDecay(), 4);
  observer.Restart(VectorXd::Constant(1, 3.0), VectorXd::Zero(1));
  VectorXd last = VectorXd::Zero(1);
  observer.AddForecast(4, last);
  EXPECT_NEAR(last[0], 3.0, 1e-13);
}

}  // namespace
}  // namespace mle::control
