#include "mle/nonlinear/stamp_noise.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

constexpr int kApart = 12;  // samples of 0.5

// One sample in twelve is measured, up to `late` samples early or late.
std::vector<Record> MeasuredNowAndThen(int late, unsigned seed) {
  std::vector<Record> records =
      MakeRecords(TwoElements(), 3000, seed, {.variance = 1e-3});
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> error(-late, late);
  for (Record& record : records) {
    const Eigen::MatrixXd all = record.outputs;
    record.outputs.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (Eigen::Index k = kApart; k + kApart < all.cols(); k += kApart) {
      record.outputs(0, k) = all(0, k + error(random));
    }
  }
  return records;
}

struct StampedFit {
  double deviation = 0.0;
  // Of the dead time of the first element: its error, and what it should be.
  double error = 0.0;
  double standard_error = 0.0;
};

StampedFit FitStamps(const std::vector<Record>& records, bool with_stamps) {
  auto setups = SetUpOutputs(TwoElements(), records, {});
  EXPECT_TRUE(setups.ok()) << setups.status();
  const OutputSetup& setup = (*setups)[0];
  OutputFit fit =
      FitOutput(*setup.problem, setup.start, {true, true}, setup.bounds, {});
  if (with_stamps) FitWithStampNoise(setup.bounds, {}, *setup.problem, fit);
  return {setup.problem->stamp_deviation(), fit.point.values[0].delay - 1.0,
          std::sqrt(fit.covariance(2, 2))};
}

// The standard deviation of errors of −1, 0 and 1 samples is 0.41. Without it
// errors of the dead time are three standard errors.
TEST(StampNoiseTest, IsFoundAndInStandardErrors) {
  constexpr int kTrials = 12;
  double with = 0.0;
  double without = 0.0;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const std::vector<Record> records = MeasuredNowAndThen(1, seed);
    const StampedFit weighed = FitStamps(records, true);
    EXPECT_NEAR(weighed.deviation, 0.43, 0.12) << "seed " << seed;
    with += std::pow(weighed.error / weighed.standard_error, 2) / kTrials;
    const StampedFit plain = FitStamps(records, false);
    without += std::pow(plain.error / plain.standard_error, 2) / kTrials;
  }
  EXPECT_LT(with, 4.0);
  EXPECT_GT(without, 2.0 * with);
}

TEST(StampNoiseTest, OfExactStampsIsSmall) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    EXPECT_LT(FitStamps(MeasuredNowAndThen(0, seed), true).deviation, 0.15);
  }
}

// Samples one after the other have no such noise.
TEST(StampNoiseTest, IsSoughtBetweenDistantSamplesOnly) {
  const auto records = MakeRecords(TwoElements(), 400, 1, {.variance = 1e-3});
  EXPECT_EQ(FitStamps(records, true).deviation, 0.0);
}

}  // namespace
}  // namespace mle
