#include "mle/maintain/estimation.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;

// An input that hardly moves beside a drift: χ² rejects too often.
std::vector<Record> HardlyMovingWindows() {
  Record record;
  record.sample_time = 0.5;
  record.inputs = Eigen::MatrixXd::Zero(1, 160);
  record.inputs.rightCols(80).setConstant(0.05);
  record.outputs = *SimulateResponse(Tank(2.0), 0.5, record.inputs);
  GaussianNoise noise(1, 0);
  double level = 0.0;
  for (int k = 0; k < record.samples(); ++k) {
    record.outputs(0, k) += level + noise.Draw(0.05);
    level += noise.Draw(0.005);
  }
  return {record};
}

EstimationOptions Options(double false_alarm_probability, ChangeTest test) {
  EstimationOptions options;
  options.estimator = Estimator::kOutputError;
  options.output_error.false_alarm_probability = false_alarm_probability;
  options.change_test = test;
  options.calibration.doubt = 1e9;  // always simulated
  return options;
}

// Between the p-value of χ² and the calibrated one each has its own verdict.
TEST(EstimationTest, TheCalibratedTestDecidesWhereChiSquareWouldPropose) {
  const std::vector<Record> windows = HardlyMovingWindows();
  const auto estimate = [&](double false_alarms, ChangeTest test) {
    auto made = EstimateModel(Tank(2.0), windows, Options(false_alarms, test));
    EXPECT_TRUE(made.ok()) << made.status();
    return *std::move(made);
  };
  const Estimate lenient = estimate(0.99, ChangeTest::kCalibrated);
  ASSERT_TRUE(lenient.fit.change_proposed);
  ASSERT_GT(lenient.fit.test.factor, 1.1);
  const double by_chi_square = lenient.fit.output_error.p_value;
  ASSERT_LT(by_chi_square, lenient.fit.test.p_value);
  const double between = std::sqrt(by_chi_square * lenient.fit.test.p_value);

  const Estimate naive = estimate(between, ChangeTest::kChiSquare);
  EXPECT_TRUE(naive.fit.change_proposed);
  EXPECT_NE(
      naive.fit.output_error.corrected.model.element(0, 0).StepResponse(1.0, 9),
      Tank(2.0).element(0, 0).StepResponse(1.0, 9));
  const Estimate calibrated = estimate(between, ChangeTest::kCalibrated);
  EXPECT_FALSE(calibrated.fit.change_proposed);
  EXPECT_EQ(
      calibrated.fit.output_error.corrected.model.element(0, 0).StaticGain(),
      2.0);
}

}  // namespace
}  // namespace mle
