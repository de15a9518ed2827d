#include "control/operating_cost.h"

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

OutputLimits Limits(double min, double max) {
  return {VectorXd::Constant(2, min), VectorXd::Constant(2, max)};
}

TEST(OperationSumsTest, AreWhatTheirEquationsSay) {
  MatrixXd outputs(2, 3), set_points(2, 3), inputs(1, 3);
  outputs << 1.0, 2.0, 3.0, 0.0, 0.0, -2.0;
  set_points << 1.0, 1.0, 1.0, 0.0, 1.0, 1.0;
  inputs << 5.0, 4.0, 6.0;
  const OperationSums sums =
      SumsOf(outputs, set_points, inputs, 0, 3, 0.5, Limits(-1.0, 2.5));
  EXPECT_EQ(sums.time, 1.5);
  EXPECT_EQ(sums.squared_error[0], 0.5 * (0.0 + 1.0 + 4.0));
  EXPECT_EQ(sums.squared_error[1], 0.5 * (0.0 + 1.0 + 9.0));
  EXPECT_EQ(sums.absolute_error[0], 0.5 * 3.0);
  EXPECT_EQ(sums.violation[0], 0.5 * 0.5);
  EXPECT_EQ(sums.violation[1], 0.5 * 1.0);
  EXPECT_EQ(sums.movement[0], 1.0 + 2.0);
}

TEST(OperationSumsTest, PartsAddUpToTheWhole) {
  const MatrixXd outputs = MatrixXd::Random(2, 40);
  const MatrixXd set_points = MatrixXd::Random(2, 40);
  const MatrixXd inputs = MatrixXd::Random(3, 40);
  const OutputLimits limits = Limits(-0.3, 0.4);
  const auto part = [&](int first, int end) {
    return SumsOf(outputs, set_points, inputs, first, end, 0.2, limits);
  };
  const OperationSums whole = part(0, 40);
  OperationSums parts = OperationSums::Zero(2, 3);
  parts.Add(part(0, 17));
  parts.Add(part(17, 40), 0.5);
  parts.Add(part(17, 40), 0.5);
  // Rounding of forty additions.
  EXPECT_NEAR(parts.time, whole.time, 1e-12);
  EXPECT_TRUE(parts.squared_error.isApprox(whole.squared_error, 1e-12));
  EXPECT_TRUE(parts.absolute_error.isApprox(whole.absolute_error, 1e-12));
  EXPECT_TRUE(parts.violation.isApprox(whole.violation, 1e-12));
  EXPECT_TRUE(parts.movement.isApprox(whole.movement, 1e-12));
}

TEST(OperationSumsTest, WithoutLimitsThereIsNoViolation) {
  const MatrixXd outputs = 100.0 * MatrixXd::Random(2, 10);
  const OperationSums sums =
      SumsOf(outputs, MatrixXd::Zero(2, 10), MatrixXd::Zero(1, 10), 0, 10, 1.0,
             Limits(-kInfinity, kInfinity));
  EXPECT_EQ(sums.violation.sum(), 0.0);
}

}  // namespace
}  // namespace mle::control
