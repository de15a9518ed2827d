#include "mle/monitor/ageing_course.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "gtest/gtest.h"
#include "mle/base/random.h"

namespace mle {
namespace {

using CourseState = AgeingCourse::State;

constexpr double kDayInformation = 400.0;  // a standard error of 5 % a day

// Days whose scores scatter about those of changes δ(day) of parameters; all
// parameters of `elements` elements are informed alike, and independently.
std::vector<ScoredBatch> DaysOf(
    int days, int elements,
    const std::function<Eigen::VectorXd(int day)>& changes,
    std::uint64_t seed = 1, double information = kDayInformation) {
  GaussianNoise noise(seed, kRunStream);
  const int n = 3 * elements;
  std::vector<ScoredBatch> batches;
  for (int day = 0; day < days; day += 2) {
    const Eigen::MatrixXd scatter =
        noise.DrawMatrix(n, 1, std::sqrt(information));
    batches.push_back(
        {.number = day,
         .length = 1,
         .score = information * changes(day) + scatter.col(0),
         .information = information * Eigen::MatrixXd::Identity(n, n)});
  }
  return batches;
}

Eigen::VectorXd Only(int n, int a, double change) {
  return change * Eigen::VectorXd::Unit(n, a);
}

TEST(AgeingCourseTest, ASteadyFallIsATrendWithItsRate) {
  int told = 0;
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto batches = DaysOf(
        240, 2, [](int day) { return Only(6, 3, -0.06 / 30.0 * day); }, seed);
    const AgeingCourse course = EstimateCourse(batches, 239, WatchOptions());
    EXPECT_NE(course.state, CourseState::kSteady) << seed;
    EXPECT_NE(course.state, CourseState::kWhichElement) << seed;
    EXPECT_EQ(course.element, 1);
    EXPECT_EQ(course.parameter, 0);
    EXPECT_NEAR(course.change.mean, -0.48, 0.06);
    told += course.state == CourseState::kTrend ? 1 : 0;
    inside += course.rate.low <= -0.06 && course.rate.high >= -0.06 ? 1 : 0;
  }
  EXPECT_GE(told, 15);
  // Of 20 with a probability of 95 % each fewer than 15 come once in 3,000.
  EXPECT_GE(inside, 15);
}

TEST(AgeingCourseTest, AStepOfLongAgoHasNoTrend) {
  const auto batches = DaysOf(
      300, 2, [](int day) { return Only(6, 0, day < 100 ? 0.0 : -0.3); });
  const AgeingCourse course = EstimateCourse(batches, 299, WatchOptions());
  EXPECT_GT(course.changed, 0.999);
  EXPECT_GT(course.probability, 0.99);
  EXPECT_NEAR(course.change.mean, -0.3, 0.05);
  EXPECT_EQ(course.state, CourseState::kSteady);
  EXPECT_LE(course.rate.low, 0.0);
  EXPECT_GE(course.rate.high, 0.0);
}

TEST(AgeingCourseTest, AStepOfLastWeekIsNoTrendEither) {
  const auto batches = DaysOf(
      200, 2, [](int day) { return Only(6, 0, day < 190 ? 0.0 : -0.5); });
  const AgeingCourse course = EstimateCourse(batches, 199, WatchOptions());
  EXPECT_NE(course.state, CourseState::kTrend);
  EXPECT_GT(course.probability, 0.99);
}

TEST(AgeingCourseTest, AFallInStepsIsATrendWithAWiderInterval) {
  // So much is known of each day that every step is seen.
  const auto batches = DaysOf(
      240, 2, [](int day) { return Only(6, 0, -0.02 * (day / 10)); }, 1,
      100.0 * kDayInformation);
  const AgeingCourse course = EstimateCourse(batches, 239, WatchOptions());
  EXPECT_EQ(course.state, CourseState::kTrend);
  EXPECT_NEAR(course.rate.mean, -0.06, 0.005);
  EXPECT_LE(course.rate.low, -0.06);
  EXPECT_GE(course.rate.high, -0.06);
}

TEST(AgeingCourseTest, WithoutAChangeNoTrendIsTold) {
  int told = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto batches = DaysOf(
        240, 2, [](int) { return Eigen::VectorXd::Zero(6); }, seed);
    const AgeingCourse course = EstimateCourse(batches, 239, WatchOptions());
    told += course.state == CourseState::kTrend ? 1 : 0;
    EXPECT_LE(course.rate.low, 0.0);
  }
  EXPECT_EQ(told, 0);
}

TEST(AgeingCourseTest, WhatWasOffFromTheStartIsNoTrend) {
  const auto batches = DaysOf(240, 1, [](int) { return Only(3, 0, 0.1); });
  const AgeingCourse course = EstimateCourse(batches, 239, WatchOptions());
  EXPECT_NE(course.state, CourseState::kTrend);
}

TEST(AgeingCourseTest, ElementsThatMoveTogetherAreNotToldApart) {
  auto batches = DaysOf(240, 2, [](int) { return Eigen::VectorXd::Zero(6); });
  for (ScoredBatch& batch : batches) {
    // Both gains act alike, but for 1e-6 of it.
    Eigen::VectorXd along = Only(6, 0, 1.0) + Only(6, 3, 1.0 + 1e-6);
    batch.information = kDayInformation * along * along.transpose();
    batch.score = -0.06 / 30.0 * batch.number * batch.information.col(0);
  }
  const AgeingCourse course = EstimateCourse(batches, 239, WatchOptions());
  EXPECT_EQ(course.state, CourseState::kWhichElement);
  EXPECT_LT(course.probability, 0.6);
}

TEST(AgeingCourseTest, ScoresThatNoCourseExplainsTellNothing) {
  const auto batches = DaysOf(
      240, 1, [](int day) { return Only(3, 0, day % 4 == 0 ? 0.3 : -0.3); });
  EXPECT_EQ(EstimateCourse(batches, 239, WatchOptions()).state,
            CourseState::kNoSingleChange);
}

TEST(AgeingCourseTest, ShortWatchesAreNotTold) {
  EXPECT_EQ(EstimateCourse({}, 100, WatchOptions()).state,
            CourseState::kTooShort);
  const auto batches =
      DaysOf(28, 1, [](int) { return Eigen::VectorXd::Zero(3); });
  EXPECT_EQ(EstimateCourse(batches, 27, WatchOptions()).state,
            CourseState::kTooShort);
  // Little information: intervals are wide.
  auto weak = DaysOf(60, 1, [](int) { return Eigen::VectorXd::Zero(3); });
  for (ScoredBatch& batch : weak) {
    batch.information *= 1e-4;
    batch.score *= 1e-2;
  }
  EXPECT_EQ(EstimateCourse(weak, 59, WatchOptions()).state,
            CourseState::kWhetherAtAll);
}

TEST(AgeingCourseTest, PointsAreFewInOrderAndHoldTheMean) {
  const auto batches =
      DaysOf(400, 1, [](int day) { return Only(3, 0, -0.001 * day); });
  const AgeingCourse course = EstimateCourse(batches, 399, WatchOptions());
  ASSERT_GE(course.points.size(), 2U);
  EXPECT_LE(course.points.size(), 40U);
  for (const CoursePoint& point : course.points) {
    EXPECT_LE(point.change.low, point.change.mean + 1e-9);
    EXPECT_GE(point.change.high, point.change.mean - 1e-9);
  }
  EXPECT_DOUBLE_EQ(course.points.back().number, 399.0);
  EXPECT_NEAR(course.points.back().change.mean, course.change.mean, 1e-9);
}

}  // namespace
}  // namespace mle
