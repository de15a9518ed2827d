#include "mle/filter/bias_filter.h"

#include <cmath>

#include "gtest/gtest.h"
#include "mle/filter/residual_prediction.h"
#include "tests/mle/filter/noise_records.h"

namespace mle {
namespace {

// Of a walk alone all horizons ask for the same gain, the Kalman filter's.
TEST(BiasFilterTest, OfARandomWalkTheKalmanGainIsBest) {
  for (const double ratio : {1e-4, 0.1, 3.0}) {
    const DisturbanceSystem system =
        SystemOf({.variance = 2.0, .ratio = ratio}, 1);
    const double kalman = SolveStationaryFilter(system).gain(0);
    for (const int horizon : {1, 30}) {
      EXPECT_NEAR(BestBiasGain(system, horizon), kalman, 1e-3 * kalman);
    }
  }
}

TEST(BiasFilterTest, OfAWalkWithoutNoiseThePlainUpdateIsBest) {
  const DisturbanceSystem system =
      SystemOf({.variance = 1e-12, .ratio = 1e6}, 1);
  EXPECT_NEAR(BestBiasGain(system, 10), 1.0, 1e-3);
}

// The expected error is the mean of those in a long record; 3 % are three
// standard errors of the mean with these memories.
TEST(BiasFilterTest, ExpectedErrorIsTheMeanOfALongRecord) {
  const NoiseEstimate lagged{.variance = 0.5,
                             .ratio = 1e-4,
                             .ar_ratio = 0.02,
                             .ar_pole = 0.9,
                             .ar_damping = 1.4};
  const NoiseEstimate first{
      .variance = 1.0, .ratio = 1e-4, .ar_ratio = 0.2, .ar_pole = 0.8};
  for (const NoiseEstimate& noise : {lagged, first}) {
    const Eigen::VectorXd record = DrawNoise(noise, 400'000, 7);
    for (const double gain : {0.05, 0.4, 1.0}) {
      for (const int samples : {1, 3}) {
        const PredictionGrid grid{.samples = samples, .horizon = 12};
        const double expected =
            BiasFilterError(SystemOf(noise, samples), gain, grid.horizon);
        const double seen =
            Together(BiasErrors(record, gain, grid, 1000, record.size()))
                .mean();
        EXPECT_NEAR(seen, expected, 0.03 * expected)
            << "gain " << gain << ", every " << samples;
      }
    }
  }
}

TEST(BiasFilterTest, NoGainOfAGridIsBetterThanTheBest) {
  const DisturbanceSystem system = SystemOf({.variance = 1.0,
                                             .ratio = 1e-3,
                                             .ar_ratio = 1e-3,
                                             .ar_pole = 0.97,
                                             .ar_damping = 1.0},
                                            2);
  const double best = BiasFilterError(system, BestBiasGain(system, 20), 20);
  for (double gain = 1e-4; gain <= 1.0; gain *= 1.05) {
    EXPECT_GE(BiasFilterError(system, gain, 20), best * (1.0 - 1e-9));
  }
}

}  // namespace
}  // namespace mle
