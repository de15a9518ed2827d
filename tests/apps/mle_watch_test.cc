// mle_watch as its users call it.

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/base/random.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/started_command.h"

namespace mle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

constexpr int kSamplesOfDay = 288;  // every 5 min
constexpr double kSampleTime = 5.0;

std::string TankJson(double gain) {
  return absl::StrCat(R"({"name": "tank", "time_unit": "min",
    "inputs": [{"name": "steam", "unit": ""}],
    "outputs": [{"name": "level", "unit": ""}],
    "elements": [{"output": "level", "input": "steam", "gain": )",
                      gain, R"(, "time_constant": 20, "delay": 10}]})");
}

// Days of a tank whose operator moves the steam, from 2026-01-01 on; its gain
// falls by a tenth on day `aged`.
class TankDays {
 public:
  TankDays(int days, int aged) {
    Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(1, days * kSamplesOfDay);
    for (int day = 0; day < days; ++day) {
      const double size = day % 2 == 0 ? 1.0 : -0.8;
      inputs.row(0)
          .segment(day * kSamplesOfDay + 60 + 7 * (day % 9), 120)
          .setConstant(size);
    }
    const Eigen::MatrixXd before = Response(2.0, inputs);
    const Eigen::MatrixXd after = Response(1.8, inputs);
    GaussianNoise noise(1, kRunStream);
    outputs_ = before;
    for (int k = aged * kSamplesOfDay; k < inputs.cols(); ++k) {
      outputs_(0, k) = after(0, k);
    }
    outputs_ += noise.DrawMatrix(1, static_cast<int>(inputs.cols()), 0.05);
    inputs_ = inputs;
  }

  // `spoilt`: an output of that many is added to one sample.
  void Write(int day, const std::string& folder, double spoilt = 0.0) const {
    std::string text = "time,level,steam\n";
    for (int k = 0; k < kSamplesOfDay; ++k) {
      const int at = day * kSamplesOfDay + k;
      const double level = outputs_(0, at) + (k == 100 ? spoilt : 0.0);
      // January has 31 days.
      absl::StrAppendFormat(&text, "2026-%02d-%02d %02d:%02d,%.6f,%.6f\n",
                            day < 31 ? 1 : 2, day < 31 ? day + 1 : day - 30,
                            k / 12, 5 * (k % 12), level, inputs_(0, at));
    }
    ASSERT_TRUE(WriteFileAtomically(
                    absl::StrFormat("%s/day%03d.csv", folder, day), text)
                    .ok());
  }

 private:
  static Eigen::MatrixXd Response(double gain, const Eigen::MatrixXd& inputs) {
    const absl::StatusOr<ProcessModel> model =
        ParseProcessModel(TankJson(gain), "tank");
    EXPECT_TRUE(model.ok()) << model.status();
    const absl::StatusOr<Eigen::MatrixXd> response =
        SimulateResponse(*model, kSampleTime, inputs);
    EXPECT_TRUE(response.ok()) << response.status();
    return *response;
  }

  Eigen::MatrixXd inputs_;
  Eigen::MatrixXd outputs_;
};

class MleWatchTest : public ::testing::Test {
 protected:
  MleWatchTest() : days_(40, 25) {
    scratch_.Write("tank.json", TankJson(2.0));
    fs::create_directories(scratch_ / "records");
    scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
        {"name": "tank", "model": "tank.json", "records": "records",
         "reference_days": 8}]})");
    alarms_ = scratch_ / "alarms.txt";
    WriteAlarmCommand(absl::StrCat("cat >>", alarms_));
  }

  void WriteAlarmCommand(const std::string& line) const {
    scratch_.Write("alarm.sh", absl::StrCat("#!/bin/sh\n", line, "\n"));
    fs::permissions(scratch_ / "alarm.sh", fs::perms::owner_all);
  }
  void WriteDays(int first, int last) const {
    for (int day = first; day < last; ++day) {
      days_.Write(day, scratch_ / "records");
    }
  }
  std::vector<std::string> Arguments(const std::string& out) const {
    return {absl::StrCat("--controllers=", scratch_ / "controllers.json"),
            absl::StrCat("--out=", scratch_ / out), "--propose=false",
            absl::StrCat("--alarm_command=", scratch_ / "alarm.sh")};
  }
  report::ProcessResult Watch(const std::string& out = "watch") const {
    return RunTested(Arguments(out));
  }
  nlohmann::json Tank(const std::string& out = "watch") const {
    return ParsedJson(scratch_ / (out + "/watch.json"))["controllers"][0];
  }
  int AlarmsHandedOn() const {
    if (!fs::exists(alarms_)) return 0;
    int count = 0;
    const std::string text = Content(alarms_);
    for (std::size_t at = text.find("\"id\""); at != std::string::npos;
         at = text.find("\"id\"", at + 1)) {
      ++count;
    }
    return count;
  }

  const TankDays days_;
  ScratchFolder scratch_;
  std::string alarms_;
};

TEST_F(MleWatchTest, LearnsWatchesAndFindsTheChange) {
  WriteDays(0, 5);
  report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Tank()["status"], "learning");
  EXPECT_THAT(Tank()["sentence"], HasSubstr("5 of 8 days"));
  WriteDays(5, 25);
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "healthy");
  EXPECT_GT(Tank()["health"], 0.9);
  EXPECT_EQ(Tank()["last_day"], "2026-01-25");
  EXPECT_EQ(AlarmsHandedOn(), 0);
  WriteDays(25, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  const nlohmann::json tank = Tank();
  EXPECT_EQ(tank["status"], "aged");
  EXPECT_LT(tank["health"], 0.5);
  ASSERT_GE(tank["alarms"].size(), 1U);
  EXPECT_GE(tank["alarms"][0]["day"], "2026-01-26");
  EXPECT_THAT(tank["alarms"][0]["text"],
              HasSubstr("its gain has changed by -"));
  EXPECT_EQ(AlarmsHandedOn(), static_cast<int>(tank["alarms"].size()));
  EXPECT_THAT(Content(scratch_ / "watch/index.html"), HasSubstr("tank"));
  EXPECT_THAT(Content(scratch_ / ("watch/" + tank["page"].get<std::string>())),
              HasSubstr("Trend"));
}

TEST_F(MleWatchTest, ARunTwiceChangesNothing) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  const std::string before = Content(scratch_ / "watch/watch.json");
  const int alarms = AlarmsHandedOn();
  EXPECT_GE(alarms, 1);
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Content(scratch_ / "watch/watch.json"), before);
  EXPECT_EQ(AlarmsHandedOn(), alarms);
}

TEST_F(MleWatchTest, WhatIsCaughtUpIsWhatWouldHaveBeenFoundDaily) {
  for (const int until : {3, 9, 10, 11, 20, 26, 29, 40}) {
    WriteDays(0, until);
    EXPECT_EQ(Watch("daily").exit_code, 0);
  }
  EXPECT_EQ(Watch("at_once").exit_code, 0);
  const nlohmann::json daily = Tank("daily");
  const nlohmann::json at_once = Tank("at_once");
  EXPECT_EQ(daily["alarms"], at_once["alarms"]);
  EXPECT_EQ(daily["elements"], at_once["elements"]);
  EXPECT_EQ(daily["days_used"], at_once["days_used"]);
}

TEST_F(MleWatchTest, LateAndCorrectedRecordsAreTakenIn) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch("right").exit_code, 0);
  // One day is missing at first, another is wrong.
  fs::remove(scratch_ / "records/day020.csv");
  days_.Write(15, scratch_ / "records", 3.0);
  EXPECT_EQ(Watch("late").exit_code, 0);
  EXPECT_NE(Tank("late")["elements"], Tank("right")["elements"]);
  WriteDays(15, 16);
  WriteDays(20, 21);
  EXPECT_EQ(Watch("late").exit_code, 0);
  EXPECT_EQ(Tank("late")["elements"], Tank("right")["elements"]);
  EXPECT_EQ(Tank("late")["days_used"], Tank("right")["days_used"]);
}

TEST_F(MleWatchTest, ABrokenControllerStopsNobody) {
  WriteDays(0, 12);
  scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
      {"name": "a", "model": "tank.json", "records": "nowhere"},
      {"name": "b", "model": "missing.json", "records": "records"},
      {"name": "tank", "model": "tank.json", "records": "records",
       "reference_days": 8}]})");
  const report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("a: records: "));
  EXPECT_THAT(run.err, HasSubstr("b: model: "));
  const nlohmann::json all =
      ParsedJson(scratch_ / "watch/watch.json")["controllers"];
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0]["status"], "failed");
  EXPECT_EQ(all[1]["status"], "failed");
  EXPECT_EQ(all[2]["status"], "healthy");
}

TEST_F(MleWatchTest, AFileThatCannotBeReadIsLeftOutAndSaid) {
  WriteDays(0, 12);
  scratch_.Write("records/broken.csv", "time,level\n\"");
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "healthy");
  EXPECT_THAT(Content(scratch_ / "watch/controller-tank.html"),
              HasSubstr("broken.csv cannot be read"));
}

TEST_F(MleWatchTest, AnotherModelBeginsAnotherWatch) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "aged");
  scratch_.Write("tank.json", TankJson(1.8));
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "learning");
  EXPECT_THAT(Tank()["alarms"], SizeIs(0));
}

TEST_F(MleWatchTest, AnAlarmThatIsNotTakenIsHandedOnAgain) {
  WriteDays(0, 40);
  WriteAlarmCommand("echo busy >&2; exit 3");
  const report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("busy"));
  WriteAlarmCommand(absl::StrCat("cat >>", alarms_));
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(AlarmsHandedOn(), static_cast<int>(Tank()["alarms"].size()));
}

TEST_F(MleWatchTest, KilledRunsAreCaughtUp) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch("whole").exit_code, 0);
  const int alarms = AlarmsHandedOn();
  for (int moment = 0; moment < 10; ++moment) {
    StartedCommand run(MLE_TESTED_COMMAND, Arguments("killed"),
                       scratch_ / "log.txt");
    std::this_thread::sleep_for(std::chrono::milliseconds(15 * moment));
    run.Send(SIGKILL);
    run.ExitCode();
  }
  EXPECT_EQ(Watch("killed").exit_code, 0);
  EXPECT_EQ(Tank("killed")["elements"], Tank("whole")["elements"]);
  EXPECT_EQ(Tank("killed")["alarms"], Tank("whole")["alarms"]);
  // Each alarm arrives; one that was being handed on at a kill says that it is
  // repeated.
  EXPECT_GE(AlarmsHandedOn(), 2 * alarms);
}

TEST_F(MleWatchTest, WrongFlagsAndFilesAreNamed) {
  report::ProcessResult run = RunTested({});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--controllers"));
  scratch_.Write("controllers.json", "{}");
  run = Watch();
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--controllers"));
  EXPECT_THAT(run.err, HasSubstr("controllers.json"));
}

TEST_F(MleWatchTest, NamesOfTagsAreNoMarkup) {
  scratch_.Write("tank.json", R"({"name": "t", "time_unit": "min",
    "inputs": [{"name": "<script>x", "unit": ""}],
    "outputs": [{"name": "level", "unit": ""}],
    "elements": [{"output": "level", "input": "<script>x", "gain": 2,
                  "time_constant": 20, "delay": 10}]})");
  scratch_.Write("tags.csv", "tag,channel\nsteam,<script>x\n");
  scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
      {"name": "tank", "model": "tank.json", "records": "records",
       "tag_file": "tags.csv", "reference_days": 8}]})");
  WriteDays(0, 12);
  const report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string page = Content(scratch_ / "watch/controller-tank.html");
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;x"));
  EXPECT_THAT(page, Not(HasSubstr("<script>x")));
}

}  // namespace
}  // namespace mle
