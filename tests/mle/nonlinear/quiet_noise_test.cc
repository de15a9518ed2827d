#include "mle/nonlinear/quiet_noise.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/plant.h"
#include "tests/mle/nonlinear/structured_records.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kWhite = 0.01;

// y = noise + plant(u), u = −gain (y − set point) every fifth sample: the
// inputs answer the noise.
Record ClosedLoop(const ProcessModel& plant, int samples, unsigned seed,
                  double increment, double feedback) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  auto simulated = sim::Plant::Create(plant, {.sample_time = 0.5});
  CHECK(simulated.ok());
  Record record;
  record.sample_time = 0.5;
  record.outputs.resize(1, samples);
  record.inputs.resize(2, samples);
  Eigen::VectorXd input = Eigen::VectorXd::Zero(2);
  double level = 5.0;
  for (int k = 0; k < samples; ++k) {
    const double y =
        simulated->outputs()(0) + level + std::sqrt(kWhite) * normal(engine);
    level += std::sqrt(increment) * normal(engine);
    if (k % 5 == 0) input(0) = -feedback * (y - 5.0);
    record.outputs(0, k) = y;
    record.inputs.col(k) = input;
    simulated->Advance(input);
  }
  return record;
}

QuietNoise Estimate(const std::vector<Record>& records,
                    const QuietNoiseOptions& options = {}) {
  const auto noise = EstimateQuietNoise(
      records, std::vector<std::vector<SetPointChange>>(records.size()),
      TwoElements(), options);
  EXPECT_TRUE(noise.ok()) << noise.status();
  return noise.ok() ? noise->at(0) : QuietNoise();
}

// Means over seeds against the truth, and errors against their standard
// errors, in open and closed loop.
TEST(QuietNoiseTest, FindsBothVariancesWithHonestErrors) {
  constexpr int kSeeds = 40;
  for (const double increment : {1e-6, 1e-4}) {
    for (const double feedback : {0.0, 0.3}) {
      double white = 0.0, drift = 0.0, white_squares = 0.0, log_squares = 0.0;
      int below_upper = 0;
      for (unsigned seed = 0; seed < kSeeds; ++seed) {
        const QuietNoise noise = Estimate(
            {ClosedLoop(TwoElements(), 2000, 2 * seed, increment, feedback),
             ClosedLoop(TwoElements(), 2000, 2 * seed + 1, increment,
                        feedback)});
        white += noise.variance / kSeeds;
        drift += noise.increment_variance / kSeeds;
        white_squares +=
            std::pow((noise.variance - kWhite) / noise.variance_error, 2) /
            kSeeds;
        log_squares +=
            std::pow(
                std::log(std::max(noise.increment_variance, 1e-9) / increment) /
                    (noise.increment_variance_error /
                     std::max(noise.increment_variance, 1e-9)),
                2) /
            kSeeds;
        below_upper += increment <= noise.increment_variance_upper;
      }
      EXPECT_NEAR(white, kWhite, 0.02 * kWhite) << increment;
      // Means of 40 estimates with a relative error of a fifth to a half.
      EXPECT_NEAR(drift / increment, 1.0, 0.3) << feedback;
      EXPECT_NEAR(white_squares, 1.0, 0.7);
      if (increment > 1e-5) {
        EXPECT_NEAR(log_squares, 1.0, 0.8);
      }
      EXPECT_GE(below_upper, kSeeds - 5);
    }
  }
}

// The control acts against the drift, at a loop gain of 0.8, so that the
// outputs drift less than what they are disturbed by.
TEST(QuietNoiseTest, TheModelTakesOffWhatInputsDo) {
  double with = 0.0;
  double without = 0.0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const std::vector<Record> records = {
        ClosedLoop(TwoElements(), 4000, seed, 1e-4, 0.4)};
    with += Estimate(records).increment_variance / 10;
    without += Estimate(records, {.use_model = false}).increment_variance / 10;
  }
  EXPECT_NEAR(with, 1e-4, 0.2e-4);
  EXPECT_LT(without, 0.7e-4);
}

// A plant with gains that are not the model's: no drift for that.
TEST(QuietNoiseTest, WhatHasAgedIsNoDrift) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.0, 4.0, 1.0);
  double held = 0.0;
  double free = 0.0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const std::vector<Record> records = {
        ClosedLoop(plant, 4000, seed, 0.0, 0.6)};
    free += Estimate(records).increment_variance / 10;
    held += Estimate(records, {.free_elements = false}).increment_variance / 10;
  }
  EXPECT_LT(free, 1e-7);
  EXPECT_GT(held, 10.0 * free);
}

TEST(QuietNoiseTest, WithoutDriftNoneIsClaimed) {
  int claimed = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const QuietNoise noise =
        Estimate({ClosedLoop(TwoElements(), 1000, seed, 0.0, 0.0)});
    claimed += noise.drift_p_value < 0.01;
    EXPECT_GE(noise.increment_variance_upper, noise.increment_variance);
  }
  EXPECT_LE(claimed, 4);
}

TEST(QuietNoiseTest, OutliersAndGapsDoNotCount) {
  Record record = ClosedLoop(TwoElements(), 4000, 7, 1e-5, 0.0);
  const QuietNoise clean = Estimate({record});
  std::mt19937_64 engine(1);
  for (int k = 0; k < 4000; ++k) {
    if (engine() % 100 == 0) record.outputs(0, k) += engine() % 2 ? 3.0 : -2.0;
    if (engine() % 20 == 0) {
      record.outputs(0, k) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  const QuietNoise dirty = Estimate({record});
  EXPECT_GE(dirty.outliers, 30);
  EXPECT_NEAR(dirty.variance / clean.variance, 1.0, 0.05);
  EXPECT_NEAR(dirty.increment_variance / clean.increment_variance, 1.0, 0.3);
}

TEST(QuietNoiseTest, ChangesOfSetPointsAreKeptOut) {
  Record record = ClosedLoop(TwoElements(), 1000, 9, 0.0, 0.0);
  record.outputs.row(0).segment(400, 40).array() += 3.0;  // a response
  const std::vector<std::vector<SetPointChange>> changes = {{{400, 0, 0, 1}}};
  const auto noise =
      EstimateQuietNoise({record}, changes, TwoElements(), {.settling = 20.0});
  ASSERT_TRUE(noise.ok());
  EXPECT_EQ(noise->at(0).stretches, 2);
  EXPECT_NEAR(noise->at(0).variance, kWhite, 0.2 * kWhite);
  const auto none = EstimateQuietNoise({record}, changes, TwoElements(),
                                       {.settling = 20.0, .min_samples = 600});
  EXPECT_EQ(none.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(none.status().message()),
              HasSubstr("'y0' has no quiet stretch: 600 samples"));
  EXPECT_FALSE(EstimateQuietNoise({record}, {}, TwoElements(), {}).ok());
}

TEST(QuietNoiseTest, ScalesWithTheOutput) {
  Record record = ClosedLoop(TwoElements(), 1500, 11, 1e-4, 0.0);
  const QuietNoise one = Estimate({record});
  record.outputs *= 1000.0;
  const QuietNoise other = Estimate({record});
  EXPECT_NEAR(other.variance / one.variance, 1e6, 1.0);
  EXPECT_NEAR(other.increment_variance / one.increment_variance, 1e6, 10.0);
}

}  // namespace
}  // namespace mle
