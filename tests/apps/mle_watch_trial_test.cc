// Corrections on trial, from the alarm to the way back, as users of mle_watch
// see them.

#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/watch_site.h"

namespace mle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MleWatchTrialTest : public WatchSite {
 protected:
  // The gain falls on day 12 and is what it was from day 30 on.
  MleWatchTrialTest() : tank_(40, 12, 30) {}

  void Look(int first, int last, const std::string& out = "watch") const {
    for (int day = first; day < last; ++day) {
      tank_.Write(day, scratch_ / "records");
    }
    std::vector<std::string> arguments = Arguments(out);
    arguments.push_back("--propose=true");
    const report::ProcessResult run = RunTested(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }
  std::string Page() const {
    return Content(scratch_ / ("watch/" + Tank()["page"].get<std::string>()));
  }
  // The id of the first alarm of that kind; empty without one.
  std::string AlarmOf(const std::string& kind) const {
    const nlohmann::json tank = Tank();
    for (const nlohmann::json& alarm : tank["alarms"]) {
      if (alarm["kind"] == kind) return alarm["id"];
    }
    return "";
  }

  const TankDays tank_;
};

TEST_F(MleWatchTrialTest, GoesFromTheCorrectionToCommissioningAndBack) {
  Look(0, 18);
  ASSERT_EQ(Tank()["proposals"][0]["decision"], "corrected");
  ASSERT_FALSE(Tank()["trial"].is_null());
  EXPECT_EQ(Tank()["trial"]["advice"], "wait");
  EXPECT_THAT(Page(), HasSubstr("Wait: it is not known yet"));

  Look(18, 23);
  EXPECT_EQ(Tank()["trial"]["advice"], "adopt");
  EXPECT_THAT(Page(), HasSubstr("Adopt the correction of 2026-01-18."));
  const std::string adopt = AlarmOf("adopt");
  ASSERT_NE(adopt, "");
  EXPECT_TRUE(Tank()["trial"]["adopted"].is_null());

  EXPECT_EQ(RunTested({absl::StrCat("--out=", scratch_ / "watch"),
                       absl::StrCat("--acknowledge=", adopt),
                       "--acknowledged_by=Ann", "--note=loaded at ten"})
                .exit_code,
            0);
  Look(23, 26);
  EXPECT_EQ(Tank()["trial"]["advice"], "keep");
  EXPECT_EQ(Tank()["trial"]["adopted"]["who"], "Ann");
  EXPECT_EQ(Tank()["trial"]["adopted"]["day"], "2026-01-24");
  EXPECT_THAT(Page(), HasSubstr("since 2026-01-24, by Ann"));

  // The list names the new model: the trial goes on.
  fs::copy_file(scratch_ / "watch/proposals/tank/2026-01-18/model.json",
                scratch_ / "tank.json", fs::copy_options::overwrite_existing);
  Look(26, 30);
  EXPECT_EQ(Tank()["trial"]["advice"], "keep");
  EXPECT_EQ(Tank()["trial"]["adopted"]["note"], "loaded at ten");

  Look(30, 35);
  EXPECT_EQ(Tank()["trial"]["advice"], "roll_back");
  EXPECT_NE(AlarmOf("roll_back"), "");
  EXPECT_THAT(Page(), HasSubstr("Roll back to the model before"));

  // The former model is in use again.
  scratch_.Write("tank.json", TankJson(2.0));
  Look(35, 36);
  EXPECT_EQ(Tank()["trial"]["ended"], "rolled_back");
  EXPECT_THAT(Page(), HasSubstr("Nothing to do: the former model"));
}

TEST_F(MleWatchTrialTest, ModelInTheListCountsAsAdopted) {
  Look(0, 18);
  ASSERT_FALSE(Tank()["trial"].is_null());
  fs::copy_file(scratch_ / "watch/proposals/tank/2026-01-18/model.json",
                scratch_ / "tank.json", fs::copy_options::overwrite_existing);
  Look(18, 20);
  EXPECT_EQ(Tank()["trial"]["adopted"]["who"], "the list of controllers");
  EXPECT_TRUE(Tank()["trial"]["adopted"]["at"].is_null());
  // Another model than both ends the trial.
  scratch_.Write("tank.json", TankJson(3.0));
  Look(20, 21);
  EXPECT_EQ(Tank()["trial"]["ended"], "replaced");
}

TEST_F(MleWatchTrialTest, WhatIsCaughtUpIsWhatWouldHaveBeenFoundDaily) {
  Look(0, 18, "daily");
  fs::copy(scratch_ / "daily", scratch_ / "at_once",
           fs::copy_options::recursive);
  for (int day = 18; day < 26; ++day) Look(day, day + 1, "daily");
  Look(25, 26, "at_once");
  const nlohmann::json daily = Tank("daily")["trial"];
  EXPECT_FALSE(daily["history"].empty());
  EXPECT_EQ(daily, Tank("at_once")["trial"]);
  // And a run twice changes nothing.
  Look(25, 26, "at_once");
  EXPECT_EQ(daily, Tank("at_once")["trial"]);
}

}  // namespace
}  // namespace mle
