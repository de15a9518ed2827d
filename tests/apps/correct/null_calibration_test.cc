#include "apps/correct/null_calibration.h"

#include <vector>

#include "apps/correct/prediction.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/distributions.h"

namespace mle::correct {
namespace {

ProcessModel Tank(double gain) {
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
      *SimulateResponse(Tank(gain), record.sample_time, record.inputs);
  record.outputs += GaussianNoise(3, 0).DrawMatrix(1, 300, 0.05);
  return {record};
}

TEST(NullCalibrationTest, WhatIsBeyondDoubtIsNotSimulated) {
  const std::vector<Record> windows = Windows(1.0);
  const auto test = CorrectStructure(Tank(2.0), windows, {});
  ASSERT_TRUE(test.ok()) << test.status();
  const auto calibration = CalibrateTest(Tank(2.0), windows, *test, {}, {});
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_TRUE(test->change_proposed);
  EXPECT_EQ(calibration->replicates, 0);
  EXPECT_EQ(calibration->p_value, test->p_value);
}

TEST(NullCalibrationTest, ADoubtfulTestIsMeasuredAgainstItsOwnMean) {
  const std::vector<Record> windows = Windows(2.0);
  auto test = CorrectStructure(Tank(2.0), windows, {});
  ASSERT_TRUE(test.ok()) << test.status();
  // A statistic that χ² rejects by a little.
  test->change_proposed = true;
  test->statistic = 14.0;
  test->p_value = ChiSquareTail(14.0, test->degrees_of_freedom);
  StructuredOptions threads;
  const auto one = CalibrateTest(Tank(2.0), windows, *test, threads, {});
  threads.threads = 3;
  const auto three = CalibrateTest(Tank(2.0), windows, *test, threads, {});
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

}  // namespace
}  // namespace mle::correct
