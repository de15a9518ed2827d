#include "mle/maintain/hold_out.h"

#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;
using testing::TankRecord;

constexpr double kNoise = 0.05;

EstimationOptions Options() {
  EstimationOptions options;
  options.estimator = Estimator::kStructured;
  options.structured.estimate_drift = false;
  options.structured.offsets = WindowOffsets::kNever;
  return options;
}

std::vector<Record> Windows(const ProcessModel& plant) {
  return {TankRecord(plant, kNoise, 1), TankRecord(plant, kNoise, 2)};
}

// The fit in percent of errors of standard deviation σ on a record.
double PercentOf(double deviation, const Record& record, int first) {
  const Eigen::RowVectorXd y =
      record.outputs.row(0).tail(record.samples() - first);
  const double spread = std::sqrt((y.array() - y.mean()).square().mean());
  return 100.0 * (1.0 - deviation / spread);
}

TEST(HoldOutTest, ACorrectionThatIsRightLeavesTheNoiseOfWhatWasHeldOut) {
  const std::vector<Record> windows = Windows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, Options());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_TRUE(estimate->fit.change_proposed);
  const auto validation = ValidateByHoldOut(*estimate, windows, 15, {});
  ASSERT_TRUE(validation.ok()) << validation.status();
  ASSERT_TRUE(validation->windows.has_value());
  ASSERT_TRUE(validation->windows->available());
  ASSERT_EQ(validation->windows->folds.size(), 2);
  ASSERT_TRUE(validation->blocks.has_value());
  // The first samples, a dead time and a time constant, are not predicted.
  const int first = 13;
  const double expected = PercentOf(kNoise, windows[0], first);
  for (const HeldOut* way : {&*validation->windows, &*validation->blocks}) {
    const FitPercent& fit = way->outputs[0].corrected;
    // Errors of some 1,800 samples: their root mean square is known to 2 %, of
    // which the fit shows a twentieth; the mean of each window adds little.
    EXPECT_NEAR(fit.one_step, expected, 0.5);
    EXPECT_NEAR(fit.several_steps, expected, 0.5);
    EXPECT_NEAR(fit.simulated, expected, 0.5);
  }
}

TEST(HoldOutTest, TheGainIsThatOfTheSumsOfSquares) {
  const std::vector<Record> windows = Windows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, Options());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto validation = ValidateByHoldOut(*estimate, windows, 15, {});
  ASSERT_TRUE(validation.ok()) << validation.status();
  double initial = 0.0;
  double count = 0.0;
  for (const Record& window : windows) {
    const Eigen::MatrixXd errors = estimate->fit.initial(window, 1);
    for (const double error : errors.row(0)) {
      if (!std::isfinite(error)) continue;
      initial += error * error;
      count += 1.0;
    }
  }
  // Of the corrected model by its fit in percent: 1 − f/100 = √(S/Σ(y − ȳ)²).
  const FitPercent& before = validation->windows->outputs[0].initial;
  const FitPercent& after = validation->windows->outputs[0].corrected;
  const double ratio =
      std::pow((100.0 - after.one_step) / (100.0 - before.one_step), 2);
  EXPECT_NEAR(validation->windows->gain, -0.5 * count * std::log(ratio),
              1e-6 * count);
  EXPECT_NEAR(initial * ratio / count, kNoise * kNoise, 0.1 * kNoise * kNoise);
  EXPECT_EQ(*validation->WorstGain(),
            std::min(validation->windows->gain, validation->blocks->gain));
}

TEST(HoldOutTest, WhatIsHeldOutHasNoPartInTheFit) {
  // The second window is of another plant: predicted from the first it is
  // predicted badly, though a fit to both would lie between.
  const std::vector<Record> windows = {TankRecord(Tank(3.0), kNoise, 1),
                                       TankRecord(Tank(-1.0), kNoise, 2)};
  const auto estimate = EstimateModel(Tank(1.5), windows, Options());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_TRUE(estimate->fit.change_proposed);
  const auto validation = ValidateByHoldOut(*estimate, windows, 15, {});
  ASSERT_TRUE(validation.ok()) << validation.status();
  EXPECT_LT(validation->windows->gain, 0.0);
  EXPECT_LT(validation->windows->outputs[0].corrected.simulated, 0.0);
  // Parts of both windows hidden: the fit to the rest of each lies in between.
  EXPECT_GT(validation->blocks->outputs[0].corrected.simulated,
            validation->windows->outputs[0].corrected.simulated);
  EXPECT_EQ(*validation->WorstGain(), validation->windows->gain);
}

TEST(HoldOutTest, OneWindowIsHeldOutInParts) {
  const std::vector<Record> windows = {TankRecord(Tank(2.0), kNoise, 1)};
  const auto estimate = EstimateModel(Tank(1.0), windows, Options());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto validation = ValidateByHoldOut(*estimate, windows, 15, {});
  ASSERT_TRUE(validation.ok()) << validation.status();
  EXPECT_FALSE(validation->windows.has_value());
  ASSERT_TRUE(validation->blocks.has_value());
  EXPECT_GT(validation->blocks->gain, 0.0);
  EXPECT_EQ(validation->shown(), &*validation->blocks);
}

TEST(HoldOutTest, WithoutAChangeTheInitialModelIsScoredAlone) {
  const std::vector<Record> windows = Windows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(2.0), windows, Options());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_FALSE(estimate->fit.change_proposed);
  const auto validation = ValidateByHoldOut(*estimate, windows, 15, {});
  ASSERT_TRUE(validation.ok()) << validation.status();
  ASSERT_EQ(validation->initial.size(), 1);
  EXPECT_NEAR(validation->initial[0].simulated,
              PercentOf(kNoise, windows[0], 13), 0.5);
  EXPECT_FALSE(validation->WorstGain().has_value());
}

TEST(HoldOutTest, TheResultDoesNotDependOnThreads) {
  const std::vector<Record> windows = Windows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, Options());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto one = ValidateByHoldOut(*estimate, windows, 15, {}, 1);
  const auto three = ValidateByHoldOut(*estimate, windows, 15, {}, 3);
  ASSERT_TRUE(one.ok() && three.ok());
  EXPECT_EQ(one->windows->gain, three->windows->gain);
  EXPECT_EQ(one->blocks->gain, three->blocks->gain);
}

TEST(HoldOutTest, OptionsNameTheFieldThatIsWrong) {
  EXPECT_NE(
      HoldOutOptions{.max_folds = 1}.Validate().message().find("max_folds"),
      std::string::npos);
  EXPECT_NE(HoldOutOptions{.horizon = -1}.Validate().message().find("horizon"),
            std::string::npos);
}

}  // namespace
}  // namespace mle
