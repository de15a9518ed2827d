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

}  // namespace
}  // namespace mle::control
