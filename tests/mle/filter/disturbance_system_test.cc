#include "mle/filter/disturbance_system.h"

#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<NoiseEstimate> Noises() {
  return {{.variance = 1.0, .ratio = 0.1},
          {.variance = 2.0, .ratio = 1e-8},
          {.variance = 1e-6, .ratio = 1e6},
          {.variance = 0.3, .ratio = 1e-4, .ar_ratio = 0.5, .ar_pole = 0.95},
          {.variance = 0.3,
           .ratio = 1e-6,
           .ar_ratio = 1e-4,
           .ar_pole = 0.98,
           .ar_damping = 1.7},
          {.variance = 0.3,
           .ratio = 1e-6,
           .ar_ratio = 1e-2,
           .ar_pole = 0.9,
           .ar_damping = 0.1}};
}

// Anderson and Moore, Optimal Filtering, 1979, ch. 4: of a walk in white noise
// P/r = (ρ + √(ρ² + 4ρ))/2.
TEST(StationaryFilterTest, ClosedFormOfARandomWalk) {
  for (const double ratio : {1e-8, 1e-3, 0.1, 1.0, 1e5}) {
    const StationaryFilter filter =
        SolveStationaryFilter(SystemOf({.variance = 3.0, .ratio = ratio}, 1));
    const double P = 0.5 * (ratio + std::sqrt(ratio * ratio + 4.0 * ratio));
    EXPECT_NEAR(filter.covariance(0, 0), 3.0 * P, 1e-12 * 3.0 * P);
    EXPECT_NEAR(filter.gain(0), P / (P + 1.0), 1e-12);
    EXPECT_NEAR(filter.innovation_variance, 3.0 * (P + 1.0),
                1e-12 * 3.0 * (P + 1.0));
  }
}

// The certificate: P solves its equation, is positive definite, and no error
// of the filter grows.
TEST(StationaryFilterTest, SolvesTheRiccatiEquation) {
  for (const NoiseEstimate& noise : Noises()) {
    for (const int samples : {1, 7}) {
      const DisturbanceSystem system = SystemOf(noise, samples);
      const StationaryFilter filter = SolveStationaryFilter(system);
      EXPECT_LT(filter.residual, 1e-10);
      EXPECT_EQ(Eigen::LLT<MatrixXd>(filter.covariance).info(), Eigen::Success);
      const MatrixXd closed = system.A - filter.gain * system.C;
      EXPECT_LT(closed.eigenvalues().cwiseAbs().maxCoeff(), 1.0);
    }
  }
}

// Of every gain the stationary error covariance is the sum of what each sample
// adds; the Kalman gain's is least.
TEST(StationaryFilterTest, NoOtherGainHasASmallerVariance) {
  for (const NoiseEstimate& noise : Noises()) {
    if (noise.ratio < 1e-5) continue;  // errors last for too long
    const DisturbanceSystem system = SystemOf(noise, 1);
    const StationaryFilter filter = SolveStationaryFilter(system);
    const auto variance = [&](const VectorXd& gain) {
      MatrixXd P = filter.covariance;
      const MatrixXd closed = system.A - gain * system.C;
      for (int k = 0; k < 20'000; ++k) {
        P = (closed * P * closed.transpose() + system.Q +
             gain * gain.transpose() * system.noise_variance)
                .eval();
      }
      return system.C.dot(P * system.C.transpose());
    };
    const double least = variance(filter.gain);
    EXPECT_NEAR(least + system.noise_variance, filter.innovation_variance,
                1e-9 * filter.innovation_variance);
    for (Eigen::Index i = 0; i < system.order(); ++i) {
      for (const double factor : {0.98, 1.02}) {
        VectorXd other = filter.gain;
        other(i) *= factor;
        EXPECT_GT(variance(other), least * (1.0 - 1e-12));
      }
    }
  }
}

// Two samples at once are one sample twice.
TEST(DisturbanceSystemTest, EverySecondSample) {
  for (const NoiseEstimate& noise : Noises()) {
    const DisturbanceSystem one = SystemOf(noise, 1);
    const DisturbanceSystem two = SystemOf(noise, 2);
    EXPECT_TRUE(two.A.isApprox(one.A * one.A, 1e-14));
    EXPECT_TRUE(
        two.Q.isApprox(one.A * one.Q * one.A.transpose() + one.Q, 1e-14));
    EXPECT_EQ(two.noise_variance, one.noise_variance);
  }
}

}  // namespace
}  // namespace mle
