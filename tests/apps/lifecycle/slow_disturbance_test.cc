#include <cmath>
#include <cstdint>

#include "Eigen/Core"
#include "apps/lifecycle/scenario.h"
#include "gtest/gtest.h"

namespace mle::lifecycle {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;

constexpr double kTime = 20.0;
constexpr double kSampleTime = 2.0;
constexpr int kSamples = 100'000;

// A path of kSamples/100 stretches, one after the other without a break.
MatrixXd LongPath(std::uint64_t seed) {
  SlowDisturbance disturbance(seed, Eigen::Vector2d(3.0, 0.5), kTime,
                              kSampleTime);
  MatrixXd path(2, kSamples);
  for (int part = 0; part < kSamples / 100; ++part) {
    const double start = part * 100 * kSampleTime;
    const MatrixXd stretch = disturbance.Draw(part + 1, start, 100);
    path.middleCols(100 * part, 100) = stretch.leftCols(100);
    disturbance.Keep(stretch, start + 100 * kSampleTime);
  }
  return path;
}

// Of the deviation that is asked for at all times, and as slow: the correlation
// of neighbours is exp(−Δt/T), within a stretch and from one to the next.
TEST(SlowDisturbanceTest, IsStationaryWithItsDeviationAndTime) {
  const MatrixXd path = LongPath(1);
  const double phi = std::exp(-kSampleTime / kTime);
  // Of the mean of kSamples squares with correlation φ² from one to the next:
  // four deviations.
  const double tolerance =
      4.0 * std::sqrt(2.0 / kSamples * (1.0 + phi * phi) / (1.0 - phi * phi));
  const double deviations[] = {3.0, 0.5};
  for (int i = 0; i < 2; ++i) {
    const RowVectorXd d = path.row(i) / deviations[i];
    const double variance = d.squaredNorm() / kSamples;
    EXPECT_NEAR(variance, 1.0, tolerance);
    const double product =
        d.head(kSamples - 1).dot(d.tail(kSamples - 1)) / (kSamples - 1);
    EXPECT_NEAR(product / variance, phi, 0.01);
  }
  EXPECT_NEAR(path.row(0).dot(path.row(1)) / kSamples / 1.5, 0.0, tolerance);
}

// What is passed over counts by its length.
TEST(SlowDisturbanceTest, ForgetsOverALongTimeOnly) {
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  double soon = 0.0;
  double late = 0.0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    SlowDisturbance disturbance(static_cast<std::uint64_t>(trial), one, kTime,
                                kSampleTime);
    const MatrixXd before = disturbance.Draw(1, 0.0, 1);
    disturbance.Keep(before, 100.0);
    const double level = before(0, 1);
    soon += level * disturbance.Draw(2, 100.0 + 0.5 * kTime, 1)(0, 0);
    late += level * disturbance.Draw(3, 100.0 + 20.0 * kTime, 1)(0, 0);
  }
  const double tolerance = 4.0 * std::sqrt(2.0 / kTrials);
  EXPECT_NEAR(soon / kTrials, std::exp(-0.5), tolerance);
  EXPECT_NEAR(late / kTrials, 0.0, tolerance);
}

}  // namespace
}  // namespace mle::lifecycle
