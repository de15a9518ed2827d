// mle_watch as its users call it.

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/started_command.h"
#include "tests/apps/watch_site.h"

namespace mle {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

using MleWatchTest = WatchSite;

// The alarms, but for how often it was tried to hand them on.
nlohmann::json Raised(const nlohmann::json& tank) {
  nlohmann::json alarms = tank["alarms"];
  for (nlohmann::json& alarm : alarms) alarm.erase("deliveries");
  return alarms;
}

TEST_F(MleWatchTest, LearnsWatchesAndFindsTheChange) {
  WriteDays(0, 5);
  report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Tank()["status"], "learning");
  EXPECT_THAT(Tank()["sentence"], HasSubstr("5 of 8 days"));
  EXPECT_TRUE(Tank()["next_change"].is_null());
  WriteDays(5, 25);
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "healthy");
  EXPECT_GT(Tank()["health"], 0.9);
  EXPECT_EQ(Tank()["last_day"], "2026-01-25");
  EXPECT_EQ(Tank()["outputs"][0]["trend"]["told"], "cannot_tell");
  EXPECT_THAT(Tank()["next_change"]["text"], Not(IsEmpty()));
  EXPECT_EQ(AlarmsHandedOn(), 0);
  WriteDays(25, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  const nlohmann::json tank = Tank();
  EXPECT_EQ(tank["status"], "aged");
  EXPECT_LT(tank["health"], 0.5);
  // At once, ten days before the end.
  EXPECT_NE(tank["outputs"][0]["trend"]["told"], "trend");
  EXPECT_LT(tank["outputs"][0]["trend"]["change"]["mean"], -0.07);
  EXPECT_EQ(tank["next_change"]["state"], "not_needed");
  ASSERT_GE(tank["alarms"].size(), 1U);
  EXPECT_GE(tank["alarms"][0]["day"], "2026-01-26");
  EXPECT_THAT(tank["alarms"][0]["text"],
              HasSubstr("its gain has changed by −"));
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

// Prices that do not fit the model are said, and stop no watch.
TEST_F(MleWatchTest, AWrongPriceListIsNamedAndStopsNothing) {
  WriteDays(0, 12);
  scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
      {"name": "tank", "model": "tank.json", "records": "records",
       "reference_days": 8,
       "prices": {"price_squared_error": [1, 2], "price_engineer_hour": 90},
       "tuning": {"control_period": 5, "prediction_horizon": 30,
                  "control_horizon": 3, "output_weight": 1,
                  "move_weight": 1}}]})");
  const report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, AllOf(HasSubstr("controllers.json: controller \"tank\""),
                             HasSubstr("price_squared_error: 2 values"),
                             HasSubstr("1 channels")));
  EXPECT_EQ(Tank()["status"], "healthy");
  EXPECT_EQ(Tank()["ageing_cost"]["told"], "cannot_tell");
}

TEST_F(MleWatchTest, AFileThatCannotBeReadIsLeftOutAndSaid) {
  WriteDays(0, 12);
  scratch_.Write("records/broken.csv", "time,level\n\"");
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "healthy");
  EXPECT_THAT(Content(scratch_ / "watch/controller-tank.html"),
              HasSubstr("broken.csv cannot be read"));
}

TEST_F(MleWatchTest, AFolderUnderAnotherNameHasTheSameRecords) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  const nlohmann::json before = Tank();
  fs::create_directory_symlink(scratch_ / "records", scratch_ / "link");
  scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
      {"name": "tank", "model": "tank.json", "records": "link",
       "reference_days": 8}]})");
  const report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Tank()["elements"], before["elements"]);
  // Of both names one is read for a correction, too.
  std::vector<std::string> arguments = Arguments("watch");
  arguments[2] = "--propose=true";
  EXPECT_EQ(RunTested(arguments).exit_code, 0);
  EXPECT_EQ(Tank()["proposals"][0]["decision"], "corrected") << Tank().dump();
}

TEST_F(MleWatchTest, ADamagedStateIsSaidAndStopsNobody) {
  WriteDays(0, 12);
  scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
      {"name": "tank", "model": "tank.json", "records": "records",
       "reference_days": 8},
      {"name": "other", "model": "tank.json", "records": "records",
       "reference_days": 8}]})");
  EXPECT_EQ(Watch().exit_code, 0);
  const std::string path = scratch_ / "watch/state.sqlite";
  std::string state = Content(path);
  // The reference's JSON of the first.
  const std::size_t at = state.find("\"variance\":0.");
  ASSERT_NE(at, std::string::npos);
  state[at + 16] = state[at + 16] == '5' ? '6' : '5';
  std::ofstream(path, std::ios::binary) << state;
  const report::ProcessResult run = Watch();
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("is damaged: it is not what was saved"));
  const nlohmann::json all =
      ParsedJson(scratch_ / "watch/watch.json")["controllers"];
  ASSERT_THAT(all, SizeIs(2));
  std::set<std::string> statuses = {all[0]["status"], all[1]["status"]};
  EXPECT_EQ(statuses, (std::set<std::string>{"failed", "healthy"}));
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

TEST_F(MleWatchTest, ACorrectionIsRunAndKeptWhole) {
  WriteDays(0, 40);
  scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
        {"name": "tank", "model": "tank.json", "records": "records",
         "reference_days": 8,
         "plan": {"error": 0.05, "max_output": [9], "min_input": "none"}}]})");
  std::vector<std::string> arguments = Arguments("watch");
  arguments[2] = "--propose=true";
  // As a run that was killed before its state was saved leaves it.
  fs::create_directories(scratch_ / "watch/proposals/tank/2026-02-09.new");
  fs::create_directories(scratch_ / "watch/proposals/tank/2026-02-09");
  scratch_.Write("watch/proposals/tank/2026-02-09/result.json", "{}");
  scratch_.Write("watch/proposals/tank/2026-02-09/old.txt", "of a killed run");
  const report::ProcessResult run = RunTested(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  ASSERT_THAT(Tank()["proposals"], SizeIs(1));
  const nlohmann::json proposal = Tank()["proposals"][0];
  EXPECT_EQ(proposal["decision"], "corrected") << proposal.dump();
  const std::string folder = scratch_ / "watch/proposals/tank/2026-02-09";
  const nlohmann::json result = ParsedJson(folder + "/result.json");
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_THAT(
      std::string(result["command"]),
      AllOf(HasSubstr("mle_correct --model="), HasSubstr("--begin=2026-01-2"),
            HasSubstr("--plan=true --plan_error=0.05"),
            HasSubstr("--plan_max_output=9 --plan_min_input=none")));
  // The gain is known better than asked for.
  EXPECT_EQ(result["plan"]["state"], "nothing_needed");
  for (const char* const file : {"report.html", "fopdt.json", "model.mat"}) {
    EXPECT_TRUE(fs::exists(absl::StrCat(folder, "/", file))) << file;
  }
  EXPECT_FALSE(fs::exists(folder + "/old.txt"));
  EXPECT_FALSE(fs::exists(folder + ".new"));
  // Once is enough.
  EXPECT_EQ(RunTested(arguments).exit_code, 0);
  EXPECT_THAT(Tank()["proposals"], SizeIs(1));
}

// Ids of the alarms as they were handed on, with those that say "repeated".
struct HandedOn {
  std::set<std::string> first;
  int twice = 0;  // handed on again without saying so
};

HandedOn ReadAlarms(const std::string& path) {
  HandedOn alarms;
  if (!fs::exists(path)) return alarms;
  std::istringstream text(Content(path));
  std::string id;
  for (std::string line; std::getline(text, line);) {
    const std::size_t at = line.find("\"id\": \"");
    if (at != std::string::npos) id = line.substr(at + 7, 32);
    if (line.find("\"repeated\": false") != std::string::npos &&
        !alarms.first.insert(id).second) {
      ++alarms.twice;
    }
    if (line.find("\"repeated\": true") != std::string::npos) {
      alarms.first.insert(id);
    }
  }
  return alarms;
}

TEST_F(MleWatchTest, KilledRunsAreCaughtUp) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch("whole").exit_code, 0);
  fs::remove(alarms_);
  // How long a run takes, for moments that cover it.
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(Watch("timed").exit_code, 0);
  const auto length = std::chrono::steady_clock::now() - begin;
  fs::remove(alarms_);
  constexpr int kMoments = 30;
  for (int moment = 0; moment < kMoments; ++moment) {
    StartedCommand run(MLE_TESTED_COMMAND, Arguments("killed"),
                       scratch_ / "log.txt");
    std::this_thread::sleep_for(length * moment / kMoments);
    run.Send(SIGKILL);
    run.ExitCode();
  }
  EXPECT_EQ(Watch("killed").exit_code, 0);
  EXPECT_EQ(Tank("killed")["elements"], Tank("whole")["elements"]);
  EXPECT_EQ(Raised(Tank("killed")), Raised(Tank("whole")));
  // Each alarm arrives; one that was being handed on at a kill says that it is
  // repeated.
  const HandedOn alarms = ReadAlarms(alarms_);
  EXPECT_EQ(alarms.first.size(), Tank("whole")["alarms"].size());
  EXPECT_EQ(alarms.twice, 0);
}

// No file may grow beyond that: as on a disk that is full. Signals of the limit
// are errors then.
TEST_F(MleWatchTest, AFullDiskLeavesTheStateWhole) {
  WriteDays(0, 26);
  EXPECT_EQ(Watch("whole").exit_code, 0);
  EXPECT_EQ(Watch("full").exit_code, 0);
  const std::string before = Content(scratch_ / "full/watch.json");
  WriteDays(26, 40);
  EXPECT_EQ(Watch("whole").exit_code, 0);
  for (const int kilobytes : {1, 8, 40, 60}) {
    const std::string script = scratch_.Write(
        "full.sh", absl::StrCat("#!/bin/bash\ntrap '' XFSZ\nulimit -f ",
                                kilobytes, "\nexec \"$@\"\n"));
    std::vector<std::string> arguments = {script, MLE_TESTED_COMMAND};
    for (const std::string& argument : Arguments("full")) {
      arguments.push_back(argument);
    }
    const absl::StatusOr<report::ProcessResult> run =
        report::RunProcess("/bin/bash", arguments, "", {});
    ASSERT_TRUE(run.ok()) << run.status();
    if (run->exit_code != 0) {
      EXPECT_THAT(run->err, HasSubstr("error: "));
    }
    if (kilobytes == 1) {
      EXPECT_NE(run->exit_code, 0);
      EXPECT_EQ(Content(scratch_ / "full/watch.json"), before);
    }
  }
  EXPECT_EQ(Watch("full").exit_code, 0);
  EXPECT_EQ(Tank("full")["elements"], Tank("whole")["elements"]);
  EXPECT_EQ(Raised(Tank("full")), Raised(Tank("whole")));
}

// The machine's clock, by which files are told, runs backwards.
TEST_F(MleWatchTest, AClockThatIsSetBackHidesNothing) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch("right").exit_code, 0);
  for (int day = 25; day < 40; ++day) {
    fs::remove(scratch_ / absl::StrFormat("records/day%03d.csv", day));
  }
  EXPECT_EQ(Watch("back").exit_code, 0);
  WriteDays(25, 40);
  for (int day = 20; day < 40; ++day) {
    const std::string file =
        scratch_ / absl::StrFormat("records/day%03d.csv", day);
    fs::last_write_time(
        file, fs::last_write_time(file) - std::chrono::hours(24 * 365));
  }
  EXPECT_EQ(Watch("back").exit_code, 0);
  EXPECT_EQ(Tank("back")["elements"], Tank("right")["elements"]);
  EXPECT_EQ(Tank("back")["alarms"], Tank("right")["alarms"]);
}

TEST_F(MleWatchTest, TwoAtOnceExcludeEachOther) {
  WriteDays(0, 40);
  WriteAlarmCommand(absl::StrCat("sleep 0.5; cat >>", alarms_));
  StartedCommand first(MLE_TESTED_COMMAND, Arguments("watch"),
                       scratch_ / "first.txt");
  StartedCommand second(MLE_TESTED_COMMAND, Arguments("watch"),
                        scratch_ / "second.txt");
  const int codes[] = {first.ExitCode(), second.ExitCode()};
  EXPECT_EQ(codes[0] + codes[1], 2);  // one is done, one refused
  EXPECT_EQ(codes[0] * codes[1], 0);
  const HandedOn alarms = ReadAlarms(alarms_);
  EXPECT_EQ(alarms.first.size(), Tank()["alarms"].size());
  EXPECT_EQ(alarms.twice, 0);
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
