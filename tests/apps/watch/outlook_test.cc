#include "apps/watch/outlook.h"

#include <algorithm>
#include <string>

#include "apps/watch/health.h"
#include "apps/watch/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/apps/watch/watched_site.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr int kDays = 200;
constexpr double kInformation = 2500.0;  // a standard error of 2 % a day

ProcessModel TankAhead() {
  const absl::StatusOr<ProcessModel> model = ParseProcessModel(
      R"({"name": "tank", "time_unit": "min",
          "inputs": [{"name": "steam", "unit": ""}],
          "outputs": [{"name": "level", "unit": "mm"}],
          "elements": [{"output": "level", "input": "steam", "gain": 2,
                        "time_constant": 20, "delay": 10}]})",
      "tank");
  EXPECT_TRUE(model.ok()) << model.status();
  return *model;
}

// As days leave it, of which the gain has changed by `of_day` × days since half
// of them; `every`: of how many days one is used.
Watch WatchOf(double of_day, int every) {
  Watch watch = WatchedSite::MakeWatch("tank", false);
  watch.sample_time = 5.0;
  watch.reference->outputs.resize(1);
  watch.reference->outputs[0].noise.variance = 0.0025;
  watch.reference->outputs[0].covariances = {1.0};
  watch.reference->low = Eigen::Vector2d(-2.0, -1.0);
  watch.reference->high = Eigen::Vector2d(2.0, 1.0);
  watch.days.clear();
  watch.outputs[0].clear();
  for (int day = 0; day < kDays; ++day) {
    watch.days[watch.first + day] = {"x", BatchState::kNothingMoved, ""};
    if (day % every != 0) continue;
    watch.days[watch.first + day].state = BatchState::kUsed;
    const double change = of_day * std::max(day - kDays / 2, 0);
    StoredBatch& stored = watch.outputs[0][day];
    stored.batch = {
        .number = day,
        .length = 1,
        .score = kInformation * change * Eigen::VectorXd::Unit(3, 0),
        .information = kInformation * Eigen::MatrixXd::Identity(3, 3)};
    stored.evidence = {.number = day, .log_output = 0.0, .log_elements = {0.0}};
  }
  return watch;
}

Report OutlookOf(const Watch& watch) {
  Controller controller;
  controller.name = "tank";
  return MakeReport(controller, TankAhead(), watch);
}

TEST(OutlookTest, ATrendIsSaidWithItsRate) {
  const Watch watch = WatchOf(-0.002, 2);
  const Report report = OutlookOf(watch);
  ASSERT_EQ(report.outlook.trends.size(), 1U);
  const OutputTrend& trend = report.outlook.trends[0];
  EXPECT_EQ(trend.course.state, AgeingCourse::State::kTrend);
  EXPECT_NEAR(trend.course.rate.mean, -0.06, 0.01);
  EXPECT_THAT(
      TrendText(report.model, 0, trend),
      AllOf(HasSubstr("last month the gain of level ← steam"), HasSubstr("−")));
  const std::string page = FormatControllerPage(report, ".");
  EXPECT_THAT(page, AllOf(HasSubstr("In the last month"),
                          HasSubstr("By how much the gain of level")));
  EXPECT_THAT(FormatOverview({report}), HasSubstr("% a month"));
  const auto json = nlohmann::json::parse(FormatController(report));
  EXPECT_EQ(json["outputs"][0]["trend"]["told"], "trend");
  EXPECT_EQ(json["outputs"][0]["trend"]["parameter"], "gain");
  EXPECT_LT(json["outputs"][0]["trend"]["change_per_month"]["high"], 0.0);
}

// An alarm is raised when little is known; what its day took for likely is not
// what all days say.
TEST(OutlookTest, ThePageBeginsWithWhatIsKnownNow) {
  const Alarm alarm{.output = 0, .element = -1, .text = "As of that day."};
  Watch watch = WatchOf(-0.002, 2);
  watch.alarms = {alarm};
  EXPECT_THAT(OutlookOf(watch).sentence,
              StartsWith("The model of level has aged. The gain of level ← "
                         "steam has changed by −"));
  watch = WatchOf(0.0, 60);
  watch.alarms = {alarm};
  EXPECT_EQ(OutlookOf(watch).sentence, "As of that day.");
}

TEST(OutlookTest, DeadTimesAreInTheModelsUnit) {
  Watch watch = WatchOf(-0.002, 2);
  for (auto& [day, stored] : watch.outputs[0]) {
    stored.batch.score = stored.batch.score.reverse().eval();
  }
  const Report report = OutlookOf(watch);
  const OutputTrend& trend = report.outlook.trends[0];
  ASSERT_EQ(trend.course.parameter, 2);
  // s = max(10 min, 20/5 min, 3 · 5 min).
  EXPECT_NEAR(trend.course.rate.mean, -0.06 * 15.0, 0.15);
  EXPECT_THAT(RateText(report.model, trend), HasSubstr(" min a month"));
}

TEST(OutlookTest, FewDaysTellNoTrendAndAreAskedFor) {
  const Watch watch = WatchOf(0.0, 60);
  const Report report = OutlookOf(watch);
  EXPECT_EQ(report.outlook.trends[0].course.state,
            AgeingCourse::State::kTooShort);
  ASSERT_TRUE(report.outlook.next.has_value());
  EXPECT_EQ(report.outlook.next->next.state, NextChange::State::kPropose);
  const std::string text = NextChangeText(report.model, *report.outlook.next);
  EXPECT_THAT(text, AllOf(HasSubstr("set point of level"), HasSubstr(" mm"),
                          HasSubstr("different days")));
  const auto json = nlohmann::json::parse(FormatController(report));
  EXPECT_EQ(json["next_change"]["state"], "proposed");
  EXPECT_EQ(json["next_change"]["set_point"], "level");
  EXPECT_GT(json["next_change"]["size"], 0.0);
  EXPECT_GE(json["next_change"]["log_evidence_expected"],
            json["next_change"]["log_evidence_of_alarm"]);
  EXPECT_THAT(FormatControllerPage(report, "."),
              HasSubstr("Next change of a set point"));
}

TEST(OutlookTest, WithManyDaysNothingIsAskedFor) {
  const Watch watch = WatchOf(0.0, 1);
  const Report report = OutlookOf(watch);
  ASSERT_TRUE(report.outlook.next.has_value());
  EXPECT_EQ(report.outlook.next->next.state, NextChange::State::kEnough);
}

TEST(OutlookTest, WithoutAReferenceNothingIsSaid) {
  Watch watch = WatchOf(0.0, 1);
  watch.reference.reset();
  const Report report = OutlookOf(watch);
  EXPECT_THAT(report.outlook.trends, IsEmpty());
  EXPECT_FALSE(report.outlook.next.has_value());
  const auto json = nlohmann::json::parse(FormatController(report));
  EXPECT_TRUE(json["next_change"].is_null());
  EXPECT_THAT(FormatControllerPage(report, "."),
              Not(HasSubstr("Next change of a set point")));
}

}  // namespace
}  // namespace mle::watch
