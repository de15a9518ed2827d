#include "apps/watch/trial.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "apps/watch/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "mle/trial/model_trial.h"
#include "tests/apps/watch/watched_site.h"

namespace mle::watch {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

ProcessModel TankOf(double gain) {
  ProcessModel tank("tank", "min", {{.name = "steam"}}, {{.name = "level"}});
  tank.element(0, 0) = TransferFunction::FirstOrder(gain, 20.0, 10.0);
  return tank;
}

// A day of two moves of the steam, from rest, with the gain 1.8.
Record DayOfTank(int day) {
  Record record;
  record.sample_time = 5.0;
  record.start_time = day * 1440.0;
  record.inputs.setZero(1, 288);
  record.inputs.middleCols(80, 100).setConstant(1.0);
  const auto k = Eigen::RowVectorXd::LinSpaced(288, 0.0, 287.0);
  record.outputs = *SimulateResponse(TankOf(1.8), 5.0, record.inputs) +
                   0.05 * (0.7 * (day + 1) * k.array().square()).sin().matrix();
  return record;
}

Watch WatchOnTrial(int days) {
  Watch watch = WatchedSite::MakeWatch("a", true);
  std::vector<Record> learned;
  for (int day = 0; day < 6; ++day) learned.push_back(DayOfTank(day));
  BeginTrial(TankOf(2.0), TankOf(1.8), 5.0, learned, 6, watch);
  DatedRecords data{.seconds_per_unit = 60.0};
  Record all = DayOfTank(7);
  for (int day = 8; day < 7 + days; ++day) {
    const Record next = DayOfTank(day);
    for (auto* values : {&all.outputs, &all.inputs}) {
      const Eigen::MatrixXd& more =
          values == &all.outputs ? next.outputs : next.inputs;
      values->conservativeResize(1, values->cols() + 288);
      values->rightCols(288) = more;
    }
  }
  all.start_time = 7 * kSecondsOfDay;
  data.records = {all};
  ContinueTrial(data, watch);
  return watch;
}

TEST(WatchTrialTest, StateComesBackToTheBit) {
  const Watch watch = WatchOnTrial(3);
  ASSERT_EQ(watch.trials.size(), 1u);
  EXPECT_EQ(watch.trials[0].fault, "");
  const std::string bytes = EncodeTrial(watch.trials[0].state);
  const absl::StatusOr<TrialState> read = DecodeTrial(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(EncodeTrial(*read), bytes);
  EXPECT_EQ(read->responses, watch.trials[0].state.responses);
  EXPECT_FALSE(read->responses.empty());
  for (const std::string& damaged :
       {std::string(), bytes.substr(8), bytes.substr(1), bytes + "12345678",
        bytes.substr(0, bytes.size() - 8), std::string(64, '\xff')}) {
    EXPECT_EQ(DecodeTrial(damaged).status().code(),
              absl::StatusCode::kDataLoss);
  }
}

TEST(WatchTrialTest, StateKeepsTrials) {
  const WatchedSite site;
  Watch watch = WatchOnTrial(3);
  watch.trials[0].adopted = {.who = "Ann", .at = 5, .note = "n"};
  watch.trials[0].adopted_day = 9;
  State state = site.OpenState();
  ASSERT_TRUE(state.Save(watch).ok());
  const absl::StatusOr<Watch> read = site.OpenState().Load("a", 1);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->trials.size(), 1u);
  const Trial& trial = read->trials[0];
  EXPECT_EQ(trial.day, 6);
  EXPECT_EQ(trial.last_day, 9);
  EXPECT_EQ(trial.adopted->who, "Ann");
  EXPECT_EQ(trial.adopted_day, 9);
  EXPECT_EQ(EncodeTrial(trial.state), EncodeTrial(watch.trials[0].state));
}

TEST(WatchTrialTest, RaisesOneAlarmToAdopt) {
  const Watch watch = WatchOnTrial(6);
  int adopt = 0;
  for (const Alarm& alarm : watch.alarms) {
    if (alarm.kind != AlarmKind::kAdopt) continue;
    ++adopt;
    EXPECT_EQ(alarm.output, -1);
    EXPECT_THAT(alarm.text, HasSubstr("Adopt the correction of 1970-01-07."));
  }
  EXPECT_EQ(adopt, 1);
  EXPECT_EQ(AlarmsOfAgeing(watch.alarms).size(), 1u);
}

TEST(WatchTrialTest, AcknowledgementMeansAdopted) {
  Watch watch = WatchOnTrial(6);
  TakeAdoption(watch);
  EXPECT_FALSE(watch.trials[0].adopted.has_value());
  for (Alarm& alarm : watch.alarms) {
    if (alarm.kind == AlarmKind::kAdopt) {
      alarm.acknowledged = {.who = "Ann", .at = 7};
    }
  }
  TakeAdoption(watch);
  ASSERT_TRUE(watch.trials[0].adopted.has_value());
  EXPECT_EQ(watch.trials[0].adopted->who, "Ann");
  EXPECT_TRUE(watch.trials[0].state.adopted);
  EXPECT_THAT(TrialSentences(*MakeTrialReport(watch, 60.0))[0],
              HasSubstr("Keep the correction"));
}

TEST(WatchTrialTest, ListSaysWhatBecomesOfATrial) {
  const Watch watch = WatchOnTrial(3);
  // The same model: other options have changed.
  EXPECT_EQ(CarryTrials(TankOf(2.0), watch)[0].ended, "");
  EXPECT_TRUE(CarryTrials(TankOf(1.8), watch)[0].adopted.has_value());
  EXPECT_EQ(CarryTrials(TankOf(3.0), watch)[0].ended, "replaced");
  Watch adopted = watch;
  adopted.trials = CarryTrials(TankOf(1.8), watch);
  EXPECT_EQ(CarryTrials(TankOf(2.0), adopted)[0].ended, "rolled_back");
  EXPECT_TRUE(HasFailed(CarryTrials(TankOf(2.0), adopted)[0]));
}

// What a trial advised last is no advice any more once it has ended.
TEST(WatchTrialTest, OverTrialsGiveNoAdvice) {
  Watch watch = WatchOnTrial(6);
  const auto report_of = [&] {
    return std::vector<Report>{
        {.name = "a", .watch = &watch, .trial = MakeTrialReport(watch, 60.0)}};
  };
  EXPECT_FALSE(report_of()[0].trial->IsOver());
  EXPECT_THAT(
      FormatMetrics(report_of(), 0),
      HasSubstr("mle_watch_trial{controller=\"a\",advice=\"adopt\"} 1"));
  EXPECT_THAT(FormatControllers(report_of()),
              HasSubstr("\"trial\": \"adopt\""));
  for (const char* ended : {"dropped", "rolled_back", "replaced", "kept"}) {
    watch.trials[0].ended = ended;
    EXPECT_TRUE(report_of()[0].trial->IsOver());
    EXPECT_THAT(FormatMetrics(report_of(), 0), Not(HasSubstr("advice=")));
    EXPECT_THAT(FormatControllers(report_of()), HasSubstr("\"trial\": null"));
  }
}

TEST(WatchTrialTest, WhatCannotBeTriedSaysWhy) {
  Watch watch = WatchedSite::MakeWatch("a", true);
  BeginTrial(TankOf(2.0), TankOf(2.0), 5.0, {}, 6, watch);
  ASSERT_EQ(watch.trials.size(), 1u);
  EXPECT_THAT(watch.trials[0].fault, HasSubstr("is the model in use"));
  const std::vector<std::string> said =
      TrialSentences(*MakeTrialReport(watch, 60.0));
  EXPECT_THAT(said[1], HasSubstr("is the model in use"));
  // Nothing is looked at, and nothing raised.
  ContinueTrial({.records = {DayOfTank(7)}, .seconds_per_unit = 60.0}, watch);
  EXPECT_EQ(watch.trials[0].last_day, 6);
}

}  // namespace
}  // namespace mle::watch
