#include "mle/maintain/no_change_test.h"

#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

ProcessModel RestingTank(double gain) {
  ProcessModel model("tank", "min", {InputChannel{"u", ""}},
                     {OutputChannel{"y", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(gain, 5.0, 1.5);
  return model;
}

std::vector<Record> Windows(double gain) {
  Record record;
  record.sample_time = 0.5;
  record.inputs = Eigen::MatrixXd::Zero(1, 300);
  record.inputs.rightCols(240).setOnes();
  record.inputs.rightCols(120).setConstant(-0.5);
  record.outputs =
      *SimulateResponse(RestingTank(gain), record.sample_time, record.inputs);
  record.outputs += GaussianNoise(3, 0).DrawMatrix(1, 300, 0.05);
  return {record};
}

TEST(NullCalibrationTest, WhatIsBeyondDoubtIsNotSimulated) {
  const std::vector<Record> windows = Windows(1.0);
  const auto test = CorrectByOutputError(RestingTank(2.0), windows, {});
  ASSERT_TRUE(test.ok()) << test.status();
  const auto calibration =
      CalibrateTest(RestingTank(2.0), windows, *test, {}, {});
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_TRUE(test->change_proposed);
  EXPECT_EQ(calibration->replicates, 0);
  EXPECT_EQ(calibration->p_value, test->p_value);
}

TEST(NullCalibrationTest, ADoubtfulTestIsMeasuredAgainstItsOwnMean) {
  const std::vector<Record> windows = Windows(2.0);
  auto test = CorrectByOutputError(RestingTank(2.0), windows, {});
  ASSERT_TRUE(test.ok()) << test.status();
  // A statistic that χ² rejects by a little.
  test->change_proposed = true;
  test->statistic = 14.0;
  test->p_value = ChiSquareTail(14.0, test->degrees_of_freedom);
  OutputErrorOptions threads;
  const auto one = CalibrateTest(RestingTank(2.0), windows, *test, threads, {});
  threads.threads = 3;
  const auto three =
      CalibrateTest(RestingTank(2.0), windows, *test, threads, {});
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->replicates, 12);
  EXPECT_EQ(one->factor, three->factor);
  EXPECT_GE(one->p_value, test->p_value);
  // Under white noise and a well excited input χ² is nearly right: 12
  // statistics of variance 6 have a mean of 3 ± 0.7.
  EXPECT_LT(one->factor, 2.0);
  EXPECT_EQ(one->p_value,
            ChiSquareTail(14.0 / one->factor, test->degrees_of_freedom));
}

// An input that hardly moves beside a drift: the likelihood has many local
// maxima along the dead time, and its ratio is far from χ².
std::vector<Record> NoiselessWindows() {
  Record record;
  record.sample_time = 0.5;
  record.inputs = Eigen::MatrixXd::Zero(1, 160);
  record.inputs.rightCols(80).setConstant(0.05);
  record.outputs = *SimulateResponse(RestingTank(2.0), 0.5, record.inputs);
  return {record};
}

// The mean of the statistic over records simulated here, without the library's
// noise.
double MeanStatistic(const std::vector<Record>& windows, int count) {
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  for (int n = 0; n < count; ++n) {
    std::vector<Record> drawn = windows;
    double level = 0.0;
    for (int k = 0; k < drawn[0].samples(); ++k) {
      drawn[0].outputs(0, k) += level + 0.05 * normal(engine);
      level += 0.005 * normal(engine);
    }
    OutputErrorOptions options;
    options.false_alarm_probability = 1e-300;
    const auto test = CorrectByOutputError(RestingTank(2.0), drawn, options);
    EXPECT_TRUE(test.ok()) << test.status();
    if (test.ok()) sum += test->statistic;
  }
  return sum / count;
}

TEST(NullCalibrationTest, TheFactorIsThatOfRecordsSimulatedElsewhere) {
  const std::vector<Record> windows = NoiselessWindows();
  auto test = CorrectByOutputError(RestingTank(2.0), windows, {});
  ASSERT_TRUE(test.ok()) << test.status();
  ASSERT_EQ(test->degrees_of_freedom, 3);
  test->change_proposed = true;
  test->statistic = 14.0;
  test->p_value = ChiSquareTail(14.0, 3);
  test->full.noise[0].variance = 0.05 * 0.05;
  test->full.noise[0].ratio = 0.01;
  NullCalibrationOptions options;
  options.replicates = 60;
  const auto calibration =
      CalibrateTest(RestingTank(2.0), windows, *test, {}, options);
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  const double expected = MeanStatistic(windows, 60) / 3.0;
  EXPECT_GT(expected, 1.3);
  // Each mean of 60 has a standard error of about an eighth of it.
  EXPECT_NEAR(calibration->factor, expected, 0.45 * expected);
  EXPECT_EQ(calibration->p_value, ChiSquareTail(14.0 / calibration->factor, 3));
  EXPECT_GT(calibration->p_value, test->p_value);
}

}  // namespace
}  // namespace mle
