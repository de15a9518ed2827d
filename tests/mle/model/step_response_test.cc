#include "mle/model/step_response.h"

#include "gtest/gtest.h"
#include "mle/model/transfer_function.h"

namespace mle {
namespace {

StepResponse ExampleResponse() {
  StepResponse response(0.5, 1, 2, 4);
  response.element(0, 0) << 0.0, 1.0, 4.0, 5.0;
  response.element(0, 1) << 0.0, 0.0, -1.0, -3.0;
  return response;
}

TEST(StepResponseTest, StartsAtZero) {
  const StepResponse response(0.2, 2, 3, 5);
  EXPECT_EQ(response.samples(), 5);
  EXPECT_EQ(response.values.cols(), 6);
  EXPECT_TRUE(response.values.isZero(0.0));
}

TEST(StepResponseTest, ElementsAreRowByRow) {
  StepResponse response(0.2, 2, 3, 5);
  response.element(1, 2)(4) = 7.0;
  EXPECT_EQ(response.values(4, 5), 7.0);
  EXPECT_EQ(FinalValues(response)(1, 2), 7.0);
  EXPECT_EQ(FinalValues(response).sum(), 7.0);
}

TEST(SquaredDistanceTest, IsASquaredNorm) {
  const StepResponse a = ExampleResponse();
  StepResponse b = ExampleResponse();
  EXPECT_EQ(SquaredDistance(a, b), 0.0);
  b.values(2, 0) += 3.0;
  b.values(3, 1) -= 4.0;
  EXPECT_EQ(SquaredDistance(a, b), 25.0);
  EXPECT_EQ(SquaredDistance(b, a), 25.0);
}

TEST(ImpulseResponsesTest, SumBackToTheStepResponse) {
  const StepResponse response = ExampleResponse();
  const Eigen::MatrixXd impulses = ImpulseResponses(response);
  ASSERT_EQ(impulses.rows(), 4);
  EXPECT_TRUE(impulses.row(0).isZero(0.0));
  for (int k = 0; k < 4; ++k) {
    const Eigen::RowVectorXd sum =
        impulses.topRows(k + 1).colwise().sum() * response.sample_time;
    EXPECT_EQ(sum, response.values.row(k)) << k;  // Exact in these numbers.
  }
}

TEST(ImpulsePeakTimesTest, FindsTheLargestMagnitude) {
  const Eigen::MatrixXd times = ImpulsePeakTimes(ExampleResponse());
  EXPECT_EQ(times(0, 0), 1.0);
  EXPECT_EQ(times(0, 1), 1.5);
}

TEST(ImpulsePeakTimesTest, ReadsTheDeadTimeRoundedUp) {
  const struct {
    double delay;
    double peak;
  } cases[] = {{0.0, 0.2}, {0.1, 0.4}, {0.2, 0.4}, {3.0, 3.2}, {7.15, 7.4}};
  for (const auto& c : cases) {
    StepResponse response(0.2, 1, 1, 101);
    // In the sample of the dead time itself the response has just begun, so
    // that the whole sample after it is the steeper one.
    response.element(0, 0) = TransferFunction::FirstOrder(-19.4, 14.4, c.delay)
                                 .StepResponse(0.2, 101);
    EXPECT_NEAR(ImpulsePeakTimes(response)(0, 0), c.peak, 1e-12) << c.delay;
  }
}

}  // namespace
}  // namespace mle
