// mle_correct --plan: the next move, from a record to result.json and the page.

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A record without set-point changes: no gain is known.
const std::vector<std::string> kQuiet = {"--setpoints=", "--duration=400"};
const std::vector<std::string> kTuning = {"--plan", "--control_period=1",
                                          "--prediction_horizon=30",
                                          "--control_horizon=5"};

std::vector<std::string> With(std::vector<std::string> flags,
                              const std::vector<std::string>& more) {
  flags.insert(flags.end(), more.begin(), more.end());
  return flags;
}

TEST(MleCorrectPlan, SaysWhatToMoveAfterARecordThatTellsNothing) {
  const HeaterExample example(Heater(), kQuiet);
  const nlohmann::json result = example.Run(kTuning);
  const nlohmann::json& plan = result["plan"];
  EXPECT_EQ(plan["state"], "found") << plan;
  ASSERT_GE(plan["steps"].size(), 2u);
  EXPECT_EQ(plan["steps"][0]["time"], 0.0);
  EXPECT_EQ(plan["steps"].back()["time"], plan["duration"]);
  ASSERT_FALSE(plan["gains"].empty());
  for (const nlohmann::json& gain : plan["gains"]) {
    EXPECT_LE(double{gain["after"]}, 1.05 * double{gain["wanted"]});
  }
  for (const nlohmann::json& channel : plan["channels"]) {
    if (!channel["limits"][1].is_null()) {
      EXPECT_LE(channel["band"][1], channel["limits"][1]) << channel;
      EXPECT_GE(channel["band"][0], channel["limits"][0]) << channel;
    }
    EXPECT_LE(channel["band"][0], channel["expected"][0]) << channel;
    EXPECT_GE(channel["band"][1], channel["expected"][1]) << channel;
  }
  EXPECT_THAT(plan["sentences"].dump(), HasSubstr("the set point of y"));
  const std::string html = Content(example.out + "/report.html");
  EXPECT_THAT(html, HasSubstr("The next move</h2>"));
}

TEST(MleCorrectPlan, ItsExecutionTellsWhatWasAsked) {
  const HeaterExample example(Heater(), kQuiet);
  const nlohmann::json plan = example.Run(kTuning)["plan"];
  // Each step of the plan, after 100 min of rest.
  std::string set_points = "--setpoints=";
  for (const nlohmann::json& step : plan["steps"]) {
    for (const auto& [name, value] : step["set_points"].items()) {
      if (set_points.back() != '=') set_points += ',';
      set_points += name + ":" + std::to_string(100.0 + double{step["time"]}) +
                    ":" + std::to_string(double{value});
    }
  }
  const HeaterExample executed(
      Heater(),
      {set_points,
       "--duration=" + std::to_string(200.0 + double{plan["duration"]})});
  const nlohmann::json result = executed.Run(
      // The first record, which is not part of this, tells a little.
      {"--plan", "--plan_error=0.11"});
  EXPECT_EQ(result["decision"], "no_change");
  EXPECT_EQ(result["plan"]["state"], "nothing_needed") << result["plan"];
}

TEST(MleCorrectPlan, NothingIsNeededWhereTheRecordsTell) {
  const HeaterExample example(WithHalvedGain(), {});
  const nlohmann::json result = example.Run({"--plan", "--plan_error=0.3"});
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["plan"]["state"], "nothing_needed");
  EXPECT_THAT(result["plan"]["sentences"].dump(),
              HasSubstr("Nothing has to be moved"));
  EXPECT_FALSE(example.Run().contains("plan"));
}

TEST(MleCorrectPlan, PricesAndTighterLimits) {
  const HeaterExample example(Heater(), kQuiet);
  const nlohmann::json priced =
      example.Run(With(kTuning, {"--plan_price_absolute=100,0"}))["plan"];
  EXPECT_EQ(priced["state"], "found");
  EXPECT_EQ(priced["priced"], true);
  EXPECT_THAT(priced["sentences"].dump(), HasSubstr("Expected cost: "));
  const nlohmann::json dearer =
      example.Run(With(kTuning, {"--plan_price_absolute=200,0"}))["plan"];
  EXPECT_NEAR(double{dearer["cost"]}, 2.0 * double{priced["cost"]},
              1e-6 * double{dearer["cost"]});
  const nlohmann::json hindered = example.Run(
      With(kTuning, {"--plan_longest=5", "--plan_error=0.001"}))["plan"];
  EXPECT_EQ(hindered["state"], "out_of_reach");
  EXPECT_NE(hindered["hindrance"], "");
  EXPECT_LE(double{hindered["duration"]}, 5.0);
}

TEST(MleCorrectPlan, OptionsOfAPlanAreRefusedWithoutOne) {
  const HeaterExample example(Heater(), kQuiet);
  for (const char* option : {"--plan_error=0.05", "--plan_longest=50",
                             "--plan_set_points=y1", "--plan_max_output=9"}) {
    const report::ProcessResult run = RunTested(
        CorrectionFlags(example.model, example.data, example.out, {option}));
    EXPECT_EQ(run.exit_code, 2) << run.out << run.err;
    const std::string name(option, std::string(option).find('='));
    EXPECT_THAT(run.err, HasSubstr(name + ": a plan is made with --plan"));
  }
}

TEST(MleCorrectPlan, RefusesBadInputInALine) {
  const HeaterExample example(Heater(), kQuiet);
  const auto refusal = [&](const std::vector<std::string>& more) {
    const report::ProcessResult run = RunTested(CorrectionFlags(
        example.model, example.data, example.out, With(kTuning, more)));
    EXPECT_EQ(run.exit_code, 2) << run.out << run.err;
    return run.err;
  };
  EXPECT_THAT(refusal({"--plan_longest=0"}),
              HasSubstr("--plan_longest=0: '0' must be > 0"));
  EXPECT_THAT(refusal({"--plan_error=0"}), HasSubstr("--plan_error=0"));
  EXPECT_THAT(refusal({"--plan_max_output=0.001"}),
              HasSubstr("--plan_max_output of y1 is 0.001, which usual "
                        "operation does not keep"));
  EXPECT_THAT(refusal({"--plan_set_points=y3"}),
              HasSubstr("--plan_set_points=y3: the model has no such output"));
  EXPECT_THAT(refusal({"--plan_price_absolute=0"}),
              HasSubstr("a price must be > 0"));
}

}  // namespace
}  // namespace mle
