#include "sim/schedule.h"

#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::sim {
namespace {

using ::testing::HasSubstr;

Schedule MakeSchedule(std::vector<Schedule::Point> points) {
  absl::StatusOr<Schedule> schedule = Schedule::Create(std::move(points));
  EXPECT_TRUE(schedule.ok()) << schedule.status();
  return *std::move(schedule);
}

TEST(ScheduleTest, InterpolatesBetweenPointsAndStaysOutside) {
  const Schedule schedule =
      MakeSchedule({{10.0, 1.0}, {20.0, 3.0}, {40.0, 2.0}});
  EXPECT_EQ(schedule.At(-5.0), 1.0);
  EXPECT_EQ(schedule.At(10.0), 1.0);
  EXPECT_EQ(schedule.At(15.0), 2.0);
  EXPECT_EQ(schedule.At(20.0), 3.0);
  EXPECT_EQ(schedule.At(30.0), 2.5);
  EXPECT_EQ(schedule.At(99.0), 2.0);
  EXPECT_EQ(schedule.LineAt(15.0).slope, 0.2);
  EXPECT_EQ(schedule.LineAt(99.0).slope, 0.0);
}

TEST(ScheduleTest, TwoPointsAtOneTimeAreAStep) {
  const Schedule schedule = MakeSchedule({{0.0, 1.0}, {8.0, 1.0}, {8.0, 5.0}});
  EXPECT_EQ(schedule.At(7.999), 1.0);
  EXPECT_EQ(schedule.At(8.0), 5.0);
  EXPECT_EQ(schedule.At(9.0), 5.0);
}

TEST(ScheduleTest, RangeAndSteepestRise) {
  const Schedule schedule =
      MakeSchedule({{0.0, 1.0}, {10.0, 6.0}, {10.0, 100.0}, {20.0, -4.0}});
  EXPECT_EQ(schedule.Min(), -4.0);
  EXPECT_EQ(schedule.Max(), 100.0);
  EXPECT_EQ(schedule.MaxSlope(), 0.5);  // A step is no slope.
  EXPECT_FALSE(schedule.IsConstant());
  EXPECT_TRUE(Schedule(3.0).IsConstant());
  EXPECT_EQ(Schedule(3.0).MaxSlope(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(schedule.Shifted(2.0).At(5.0), schedule.At(5.0) + 2.0);
}

TEST(ScheduleTest, PointsAreChecked) {
  const auto message = [](std::vector<Schedule::Point> points) {
    return std::string(Schedule::Create(std::move(points)).status().message());
  };
  EXPECT_THAT(message({}), HasSubstr("empty"));
  EXPECT_THAT(message({{0.0, 1.0}, {-1.0, 1.0}}),
              HasSubstr("point 2 is at time -1, the one before at 0"));
  EXPECT_THAT(message({{1.0, 1.0}, {1.0, 2.0}, {1.0, 3.0}}),
              HasSubstr("three points are at time 1"));
  EXPECT_THAT(message({{std::numeric_limits<double>::infinity(), 1.0}}),
              HasSubstr("must be finite"));
}

}  // namespace
}  // namespace mle::sim
