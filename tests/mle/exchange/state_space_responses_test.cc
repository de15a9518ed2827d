#include "mle/exchange/state_space_responses.h"

#include <cmath>

#include "Eigen/Core"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// Two outputs, each a lag of its own input alone; the first has gain 2.
NamedStateSpace TwoLags(double first_pole, double second_pole) {
  NamedStateSpace named;
  named.name = "tank";
  named.time_unit = "s";
  named.inputs = {"a", "b"};
  named.outputs = {"c", "d"};
  DiscreteStateSpace& system = named.system;
  system.sample_time = 0.5;
  system.A = Eigen::Vector2d(first_pole, second_pole).asDiagonal();
  system.B =
      Eigen::Vector2d(2.0 * (1.0 - first_pole), 1.0 - second_pole).asDiagonal();
  system.C = Eigen::Matrix2d::Identity();
  system.D = Eigen::Matrix2d::Zero();
  system.input_delays = {0, 3};
  system.output_delays = {0, 0};
  return named;
}

TEST(StepResponsesOf, SamplesUntilAllHasSettled) {
  const absl::StatusOr<StepResponseModel> steps =
      StepResponsesOf(TwoLags(0.9, 0.8));
  ASSERT_TRUE(steps.ok()) << steps.status();
  EXPECT_EQ(steps->interval, 0.5);
  EXPECT_EQ(steps->channels.outputs()[1].name, "d");
  EXPECT_EQ(steps->channels.time_unit(), "s");
  // 0.9^N = 1e-4, after the longest dead time.
  EXPECT_EQ(steps->length(), std::ceil(std::log(1e-4) / std::log(0.9)) + 3);
  ASSERT_EQ(steps->pairs.size(), 2U);  // the others are zero
  for (int k = 1; k <= steps->length(); ++k) {
    EXPECT_NEAR(steps->pairs[0].coefficients(k - 1),
                2.0 * (1.0 - std::pow(0.9, k)), 1e-13);
    EXPECT_NEAR(steps->pairs[1].coefficients(k - 1),
                k <= 3 ? 0.0 : 1.0 - std::pow(0.8, k - 3), 1e-13);
  }
}

TEST(StepResponsesOf, SlowModelsHaveALongerInterval) {
  const absl::StatusOr<StepResponseModel> steps =
      StepResponsesOf(TwoLags(0.999, 0.8));
  ASSERT_TRUE(steps.ok()) << steps.status();
  EXPECT_LE(steps->length(), 600);
  const auto stride = static_cast<int>(std::lround(steps->interval / 0.5));
  EXPECT_EQ(steps->interval, 0.5 * stride);
  EXPECT_NEAR(steps->pairs[0].coefficients(9),
              2.0 * (1.0 - std::pow(0.999, 10 * stride)), 1e-12);
  EXPECT_NEAR(steps->pairs[0].coefficients(steps->length() - 1), 2.0, 2e-4);
}

// A response of finite length has no mode that decays.
TEST(StepResponsesOf, NilpotentModelsAreSampledToTheirEnd) {
  NamedStateSpace named = TwoLags(0.0, 0.0);
  named.system.A(0, 1) = 1.0;
  const absl::StatusOr<StepResponseModel> steps = StepResponsesOf(named);
  ASSERT_TRUE(steps.ok()) << steps.status();
  EXPECT_EQ(steps->length(), 10);  // the fewest that a model may have
  ASSERT_EQ(steps->pairs.size(), 3U);
  EXPECT_EQ(steps->pairs[0].coefficients(0), 2.0);
  EXPECT_EQ(steps->pairs[1].coefficients(3), 0.0);
  EXPECT_EQ(steps->pairs[1].coefficients(4), 1.0);
}

// A level: 0.1 a sample after the dead time, and a lag beside it.
TEST(StepResponsesOf, LevelsEndInRamps) {
  NamedStateSpace named = TwoLags(0.9, 1.0);
  named.system.B(1, 1) = 0.1;
  const absl::StatusOr<StepResponseModel> steps = StepResponsesOf(named);
  ASSERT_TRUE(steps.ok()) << steps.status();
  ASSERT_EQ(steps->pairs.size(), 2U);
  EXPECT_FALSE(steps->pairs[0].is_ramp);
  EXPECT_TRUE(steps->pairs[1].is_ramp);
  for (int k = 1; k <= steps->length(); ++k) {
    EXPECT_NEAR(steps->pairs[1].coefficients(k - 1),
                k <= 3 ? 0.0 : 0.1 * (k - 3), 1e-12);
  }
}

TEST(StepResponsesOf, SaysWhatCannotBeSampled) {
  NamedStateSpace through = TwoLags(0.9, 0.8);
  through.system.D(1, 0) = -0.25;
  EXPECT_THAT(StepResponsesOf(through).status().ToString(),
              HasSubstr("D is -0.25 for 'd' from 'a'"));
  EXPECT_THAT(StepResponsesOf(TwoLags(1.0 - 1e-8, 0.8)).status().ToString(),
              HasSubstr("take a longer sample time"));
  EXPECT_FALSE(StepResponsesOf(TwoLags(1.1, 0.8)).ok());
}

}  // namespace
}  // namespace mle
