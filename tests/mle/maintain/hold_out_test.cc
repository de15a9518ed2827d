#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/maintain/validation.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;
using testing::TankRecord;

constexpr double kNoise = 0.05;

EstimationOptions HoldOutOf() {
  EstimationOptions options;
  options.estimator = Estimator::kOutputError;
  options.output_error.estimate_drift = false;
  options.output_error.offsets = WindowOffsets::kNever;
  return options;
}

std::vector<Record> HoldOutWindows(const ProcessModel& plant) {
  return {TankRecord(plant, kNoise, 1), TankRecord(plant, kNoise, 2)};
}

// The fit in percent of errors of standard deviation σ on a record.
double PercentOf(double deviation, const Record& record, int first) {
  const Eigen::RowVectorXd y =
      record.outputs.row(0).tail(record.samples() - first);
  const double spread = std::sqrt((y.array() - y.mean()).square().mean());
  return 100.0 * (1.0 - deviation / spread);
}

absl::StatusOr<Validation> Validate(const Estimate& estimate,
                                    const std::vector<Record>& windows,
                                    int changes = 2, int threads = 1) {
  return ValidateByHoldOut(estimate, windows, changes, 15, {}, {}, threads);
}

TEST(HoldOutTest, ACorrectionThatIsRightLeavesTheNoiseOfWhatWasHeldOut) {
  const std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_TRUE(estimate->fit.change_proposed);
  const auto validation = Validate(*estimate, windows);
  ASSERT_TRUE(validation.ok()) << validation.status();
  ASSERT_TRUE(validation->held_out);
  ASSERT_EQ(validation->folds.size(), 5);
  ASSERT_EQ(validation->windows.size(), 2);
  // The first samples, a dead time and a time constant, are not predicted.
  const int first = 13;
  const double expected = PercentOf(kNoise, windows[0], first);
  const OutputScores& scores = validation->outputs[0];
  for (const HorizonScore& score :
       {scores.one_step, scores.several_steps, scores.simulated}) {
    // Errors of some 1,800 samples: their root mean square is known to 2 %, of
    // which the fit shows a twentieth; the level of each window adds little.
    EXPECT_NEAR(score.corrected, expected, 0.7);
    EXPECT_GT(score.gain, 5.0 * score.error);
  }
}

TEST(HoldOutTest, TheGainIsTheShareOfTheSquaredErrorRemoved) {
  const std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto validation = Validate(*estimate, windows);
  ASSERT_TRUE(validation.ok()) << validation.status();
  const OutputScores& scores = validation->outputs[0];
  for (const HorizonScore& score :
       {scores.one_step, scores.several_steps, scores.simulated}) {
    // By the fits in percent: 1 − f/100 = √(S/Σ(y − ȳ)²).
    const double ratio =
        std::pow((100.0 - score.corrected) / (100.0 - score.initial), 2);
    EXPECT_NEAR(score.gain, 1.0 - ratio, 1e-9);
  }
  // Measured squares of both windows are those of the output.
  double squares = 0.0;
  double of_simulation = 0.0;
  for (const Record& window : windows) {
    const Eigen::MatrixXd errors = estimate->fit.initial(window, 0);
    const int first = 13;
    const Eigen::RowVectorXd y =
        window.outputs.row(0).tail(window.samples() - first);
    squares += (y.array() - y.mean()).square().sum();
    of_simulation += errors.row(0).tail(window.samples() - first).squaredNorm();
  }
  EXPECT_NEAR(scores.simulated.initial,
              100.0 * (1.0 - std::sqrt(of_simulation / squares)), 3.0);
}

// One step of the input in each window, in the same tenth of it: a fold that
// hid both would know nothing of time constant and dead time.
// The inputs before a window are neither held out nor scored.
TEST(HoldOutTest, LeadsHaveNoPart) {
  std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.5), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto validation = Validate(*estimate, windows);
  for (Record& window : windows) {
    Record led = window;
    led.inputs = Eigen::MatrixXd::Zero(1, 1100);
    led.inputs.rightCols(900) = window.inputs;
    led.outputs = Eigen::MatrixXd::Constant(1, 1100, kNaN);
    led.outputs.rightCols(900) = window.outputs;
    led.set_points = Eigen::MatrixXd::Zero(1, 1100);
    led.set_points.rightCols(900) = window.set_points;
    window = led;
  }
  const auto led = EstimateModel(Tank(1.5), windows, HoldOutOf());
  ASSERT_TRUE(led.ok()) << led.status();
  const auto same = Validate(*led, windows);
  ASSERT_TRUE(validation.ok() && same.ok());
  ASSERT_TRUE(same->held_out);
  EXPECT_NEAR(same->outputs[0].simulated.initial,
              validation->outputs[0].simulated.initial, 0.5);
  EXPECT_NEAR(same->outputs[0].simulated.corrected,
              validation->outputs[0].simulated.corrected, 0.5);
}

TEST(HoldOutTest, NoFoldHidesTheSameMoveOfAllWindows) {
  std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Record& window = windows[w];
    window.inputs.setZero();
    window.inputs.rightCols(430).setOnes();
    window.outputs = *SimulateResponse(Tank(2.0), 0.5, window.inputs) +
                     GaussianNoise(7 + w, 0, kMeasurementNoise)
                         .DrawMatrix(1, window.samples(), kNoise);
  }
  const auto estimate = EstimateModel(Tank(1.9), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto validation = Validate(*estimate, windows);
  ASSERT_TRUE(validation.ok()) << validation.status();
  ASSERT_TRUE(validation->held_out);
  const double expected = PercentOf(kNoise, windows[0], 13);
  const OutputScores& scores = validation->outputs[0];
  for (const HorizonScore& score :
       {scores.one_step, scores.several_steps, scores.simulated}) {
    EXPECT_NEAR(score.corrected, expected, 0.4);
  }
  EXPECT_GT(scores.simulated.gain, 2.0 * scores.simulated.error);
}

// Errors of a model that knows nothing are the noise; what a fold's correction
// adds to it is x, and 2 √Σ(xε)² its standard error. In white noise the gain of
// a correction of nothing is within it.
TEST(HoldOutTest, TheStandardErrorCoversWhatChanceDoes) {
  int beyond = 0;
  int scored = 0;
  double gains = 0.0;
  for (int seed = 1; seed <= 20; ++seed) {
    const std::vector<Record> windows = {
        TankRecord(Tank(2.0), kNoise, 2 * seed),
        TankRecord(Tank(2.0), kNoise, 2 * seed + 1)};
    // Tested at a level at which it always finds something.
    EstimationOptions options = HoldOutOf();
    options.change_test = ChangeTest::kChiSquare;
    options.output_error.false_alarm_probability = 0.999;
    const auto estimate = EstimateModel(Tank(2.0), windows, options);
    ASSERT_TRUE(estimate.ok()) << estimate.status();
    if (!ProposesChange(*estimate, 0)) continue;
    const auto validation = Validate(*estimate, windows);
    ASSERT_TRUE(validation.ok()) << validation.status();
    const HorizonScore& score = validation->outputs[0].one_step;
    ASSERT_TRUE(std::isfinite(score.gain));
    ASSERT_GT(score.error, 0.0);
    ++scored;
    gains += score.gain;
    if (score.gain > 2.0 * score.error) ++beyond;
  }
  ASSERT_GT(scored, 15);
  // 2.3 % expected: P(more than 3 of 20) is 0.1 %.
  EXPECT_LE(beyond, 3);
  // Parameters of a fit take as much off the errors of what it saw as they add
  // to those of what was hidden from it.
  EXPECT_LT(gains, 0.0);
}

TEST(HoldOutTest, WhatIsHeldOutHasNoPartInTheFit) {
  const std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto validation = Validate(*estimate, windows);
  ASSERT_TRUE(validation.ok()) << validation.status();
  // Spikes in the first tenth of a window: every other part is predicted as
  // before by the fold that hides them, so that the correction stays what it
  // was but for the folds that see them.
  std::vector<Record> spiked = windows;
  const int tenth = windows[0].samples() / 10;
  for (int k = tenth / 2; k < tenth; ++k) spiked[0].outputs(0, k) += 1e3;
  const auto again = Validate(*estimate, spiked);
  ASSERT_TRUE(again.ok()) << again.status();
  // The spikes are scored where they are hidden and spoil the other folds.
  EXPECT_LT(again->outputs[0].simulated.corrected,
            validation->outputs[0].simulated.corrected - 10.0);
}

TEST(HoldOutTest, WindowsOfTwoPlantsAreNotBothPredictedBetter) {
  const std::vector<Record> windows = {TankRecord(Tank(3.0), kNoise, 1),
                                       TankRecord(Tank(1.4), kNoise, 2)};
  const auto estimate = EstimateModel(Tank(1.5), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_TRUE(estimate->fit.change_proposed);
  const auto validation = Validate(*estimate, windows);
  ASSERT_TRUE(validation.ok()) << validation.status();
  EXPECT_GT(validation->windows[0][0].simulated.gain, 0.0);
  EXPECT_LT(validation->windows[1][0].simulated.gain, 0.0);
}

TEST(HoldOutTest, OneWindowIsHeldOutOnlyWithSeveralChanges) {
  const std::vector<Record> windows = {TankRecord(Tank(2.0), kNoise, 1)};
  const auto estimate = EstimateModel(Tank(1.0), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto few = Validate(*estimate, windows, 3);
  ASSERT_TRUE(few.ok()) << few.status();
  EXPECT_FALSE(few->held_out);
  EXPECT_FALSE(few->missing.empty());
  EXPECT_TRUE(few->windows.empty());
  const auto several = Validate(*estimate, windows, 4);
  ASSERT_TRUE(several.ok()) << several.status();
  EXPECT_TRUE(several->held_out);
  EXPECT_GT(several->outputs[0].one_step.gain,
            2.0 * several->outputs[0].one_step.error);
}

TEST(HoldOutTest, WithoutAChangeTheInitialModelIsScoredAlone) {
  const std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(2.0), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_FALSE(estimate->fit.change_proposed);
  const auto validation = Validate(*estimate, windows);
  ASSERT_TRUE(validation.ok()) << validation.status();
  ASSERT_EQ(validation->outputs.size(), 1);
  EXPECT_FALSE(validation->held_out);
  EXPECT_NEAR(validation->outputs[0].simulated.initial,
              PercentOf(kNoise, windows[0], 13), 0.5);
  EXPECT_TRUE(std::isnan(validation->outputs[0].simulated.gain));
}

TEST(HoldOutTest, TheResultDoesNotDependOnThreads) {
  const std::vector<Record> windows = HoldOutWindows(Tank(2.0));
  const auto estimate = EstimateModel(Tank(1.0), windows, HoldOutOf());
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto one = Validate(*estimate, windows, 2, 1);
  const auto three = Validate(*estimate, windows, 2, 3);
  ASSERT_TRUE(one.ok() && three.ok());
  EXPECT_EQ(one->outputs[0].one_step.gain, three->outputs[0].one_step.gain);
  EXPECT_EQ(one->outputs[0].simulated.error, three->outputs[0].simulated.error);
}

TEST(HoldOutTest, OptionsNameTheFieldThatIsWrong) {
  const auto message = [](const HoldOutOptions& options) {
    return std::string(options.Validate().message());
  };
  EXPECT_NE(message({.folds = 1}).find("folds"), std::string::npos);
  EXPECT_NE(message({.horizon = -1}).find("horizon"), std::string::npos);
  EXPECT_NE(message({.fewest_changes = 1}).find("fewest_changes"),
            std::string::npos);
}

}  // namespace
}  // namespace mle
