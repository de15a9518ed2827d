#include "sim/set_point_profile.h"

#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::sim {
namespace {

using ::testing::HasSubstr;

TEST(SetPointProfileTest, IsZeroBeforeAndHoldsAfterAStep) {
  const SetPointProfile profile{
      .steps = {{.output = 1, .time = 500.0, .value = 2.0}}};
  const Eigen::MatrixXd r = profile.Sample(2, 0.2, 5001);
  ASSERT_EQ(r.rows(), 2);
  ASSERT_EQ(r.cols(), 5001);
  EXPECT_EQ(r.row(0).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(r.row(1).head(2500).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(r.row(1).tail(2501).minCoeff(), 2.0);
  EXPECT_EQ(r.row(1).tail(2501).maxCoeff(), 2.0);
}

TEST(SetPointProfileTest, StepBetweenSamplesShowsAtTheNextOne) {
  const SetPointProfile profile{.steps = {{.time = 0.31, .value = 1.0}}};
  const Eigen::MatrixXd r = profile.Sample(1, 0.1, 6);
  EXPECT_EQ(r, (Eigen::RowVectorXd(6) << 0, 0, 0, 0, 1, 1).finished());
}

TEST(SetPointProfileTest, ProfileOfSamplesHasThem) {
  Eigen::MatrixXd samples(2, 6);
  samples << 1, 1, 0, 0, 3, 3, 0, 0, 0, -2, -2, 0;
  const SetPointProfile profile = ProfileOf(samples, 0.2);
  EXPECT_EQ(profile.steps.size(), 5u);
  EXPECT_EQ(profile.Sample(2, 0.2, 6), samples);
}

// 0.1 · 3 and 0.6/0.2 are not whole in binary.
TEST(SetPointProfileTest, StepOnASampleButForRoundingShowsThere) {
  for (const double time : {0.6, 0.2 * 3.0, 0.6 + 1e-11, 0.6 - 1e-11}) {
    const SetPointProfile profile{.steps = {{.time = time, .value = 1.0}}};
    const Eigen::MatrixXd r = profile.Sample(1, 0.2, 5);
    EXPECT_EQ(r, (Eigen::RowVectorXd(5) << 0, 0, 0, 1, 1).finished()) << time;
  }
}

TEST(SetPointProfileTest, OrderInTheListMattersForEqualTimesOnly) {
  const SetPointStep early{.time = 1.0, .value = 3.0};
  const SetPointStep late{.time = 2.0, .value = 5.0};
  const SetPointStep again{.time = 2.0, .value = 7.0};
  const Eigen::MatrixXd in_order =
      SetPointProfile{.steps = {early, late, again}}.Sample(1, 1.0, 4);
  EXPECT_EQ(in_order, (Eigen::RowVectorXd(4) << 0, 3, 7, 7).finished());
  EXPECT_EQ((SetPointProfile{.steps = {late, again, early}}.Sample(1, 1.0, 4)),
            in_order);
  EXPECT_EQ((SetPointProfile{.steps = {again, late, early}}.Sample(1, 1.0, 4)),
            (Eigen::RowVectorXd(4) << 0, 3, 5, 5).finished());
}

TEST(SetPointProfileTest, StepsOutsideTheRecord) {
  const SetPointProfile profile{
      .steps = {{.time = -3.0, .value = 1.0}, {.time = 1e30, .value = 2.0}}};
  EXPECT_EQ(profile.Sample(1, 1.0, 3), Eigen::RowVectorXd::Ones(3));
}

TEST(SetPointProfileTest, ValidateNamesTheStepAndWhatIsWrong) {
  SetPointProfile profile{.steps = {{.output = 0}, {.output = 2}}};
  const absl::Status wrong_output = profile.Validate(2);
  EXPECT_EQ(wrong_output.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(wrong_output.message()),
              HasSubstr("set-point step 2: output = 2"));
  EXPECT_TRUE(profile.Validate(3).ok());

  profile.steps[0].time = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(std::string(profile.Validate(3).message()),
              HasSubstr("set-point step 1: time = nan"));
  profile.steps[0] = {.value = std::numeric_limits<double>::infinity()};
  EXPECT_FALSE(profile.Validate(3).ok());
  profile.steps[0] = {.output = -1};
  EXPECT_FALSE(profile.Validate(3).ok());
}

// A ramp of 3 over [1, 4], upon steps, at two rates of sampling.
TEST(SetPointProfileTest, MovesAreAddedAndRampsAreLinear) {
  const SetPointProfile profile{
      .steps = {{.time = 2.0, .value = 10.0}},
      .moves = {{0, {.time = 1.0, .size = 3.0, .duration = 3.0}},
                {0, {.time = 5.0, .size = -1.0}}}};
  const Eigen::MatrixXd coarse = profile.Sample(1, 1.0, 7);
  const Eigen::RowVectorXd expected{{0, 0, 11, 12, 13, 12, 12}};
  EXPECT_LE((coarse - expected).cwiseAbs().maxCoeff(), 1e-8);
  const Eigen::MatrixXd fine = profile.Sample(1, 0.25, 25);
  for (int k = 0; k < 7; ++k) EXPECT_NEAR(fine(0, 4 * k), coarse(0, k), 1e-8);
  EXPECT_NEAR(fine(0, 6), 0.5, 1e-8);  // at 1.5
  EXPECT_FALSE((SetPointProfile{.steps = {}, .moves = {{0, {.duration = -1.0}}}}
                    .Validate(1)
                    .ok()));
  EXPECT_FALSE(
      (SetPointProfile{.steps = {}, .moves = {{1, {}}}}.Validate(1).ok()));
}

TEST(SetPointProfileTest, AnOptimiserMovesAboutTheProfile) {
  const SetPointProfile profile{
      .steps = {{.output = 1, .time = 0.0, .value = 5.0}},
      .moves = DrawOptimiserMoves(1, 2.0, 0.1, 20000.0, 3, 0)};
  const Eigen::MatrixXd r = profile.Sample(2, 1.0, 20000);
  EXPECT_EQ(r.row(0).norm(), 0.0);
  EXPECT_EQ(r(1, 1), 5.0);
  const Eigen::RowVectorXd distance = r.row(1).array() - 5.0;
  // 10,000 levels: a standard error of 0.7 % of the deviation.
  EXPECT_NEAR(std::sqrt(distance.squaredNorm() / 20000.0), 0.1, 0.004);
  for (int k = 2; k < 100; k += 2) {
    EXPECT_EQ(r(1, k), r(1, k + 1));
    EXPECT_NE(r(1, k), r(1, k - 1));
  }
}

}  // namespace
}  // namespace mle::sim
