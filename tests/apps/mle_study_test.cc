// mle_study as its users call it.

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/experiment/small_campaign.h"
#include "tests/apps/page_tables.h"
#include "tests/apps/readable_page.h"
#include "tests/apps/report/browser.h"

namespace mle {
namespace {

using experiment::SmallCampaign;
using ::testing::HasSubstr;

class MleStudyTest : public ::testing::Test {
 protected:
  // Writes the campaign and runs it; gives the folder.
  std::string Run(const nlohmann::json& campaign, const std::string& out,
                  const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "--campaign=" + scratch_.Write("campaign.json", campaign.dump()),
        "--out=" + scratch_ / out, "--figures=false"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    result_ = RunTested(arguments);
    return scratch_ / out;
  }

  const ScratchFolder scratch_;
  report::ProcessResult result_;
};

TEST_F(MleStudyTest, TheSameBytesForAnyNumberOfThreads) {
  nlohmann::json campaign = SmallCampaign(2);
  campaign["estimators"] = {"none", "arx:none", "arx", "output_error:none",
                            "output_error"};
  campaign["selections"] = {"paper", "bic"};
  const std::string one = Run(campaign, "one", {"--threads=1"});
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  const std::string three = Run(campaign, "three", {"--threads=3"});
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  for (const char* file : {"runs.csv", "summary.csv", "summary.json"}) {
    EXPECT_EQ(Content(one + "/" + file), Content(three + "/" + file)) << file;
  }
  EXPECT_EQ(ParsedCsv(one + "/runs.csv").size(),
            1U + 2U * 2U * (1U + 2U + 2U + 1U + 1U));
}

// A run alone gives the same as among others: work that is shared is the same
// work.
TEST_F(MleStudyTest, ARunDoesNotDependOnItsCampaign) {
  nlohmann::json large = SmallCampaign(2);
  large["selections"] = {"bic", "paper"};
  const auto all = ParsedCsv(Run(large, "large") + "/runs.csv");
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  nlohmann::json small = SmallCampaign(1);
  small["seeds"] = {2};
  small["mismatches"].erase(0);
  const auto one = ParsedCsv(Run(small, "small") + "/runs.csv");
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  ASSERT_EQ(one.size(), 2U);
  int found = 0;
  for (const auto& line : all) {
    if (std::vector<std::string>(line.begin() + 1, line.end()) ==
        std::vector<std::string>(one[1].begin() + 1, one[1].end())) {
      ++found;
    }
  }
  EXPECT_EQ(found, 1);
}

// The same experiment by mle_reproduce: E, λ and the best λ to the last digit.
TEST_F(MleStudyTest, AgreesWithMleReproduce) {
  nlohmann::json campaign = SmallCampaign(2);
  const std::string model =
      scratch_.Write("model.json", campaign["models"][0]["model"].dump());
  nlohmann::json aged = campaign["models"][0]["model"];
  aged["elements"][1]["delay"] = 4;
  const std::string plant = scratch_.Write("plant.json", aged.dump());
  campaign["models"] = {{{"name", "m"}, {"file", "model.json"}}};
  campaign["mismatches"] = {{{"name", "aged"}, {"plant", "plant.json"}}};
  const auto runs = ParsedCsv(Run(campaign, "out") + "/runs.csv");
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  const auto reproduced = report::RunProcess(
      MLE_REPRODUCE_COMMAND,
      {"--model=" + model, "--plants=aged:" + plant, "--seeds=2",
       "--out=" + scratch_ / "reproduced", "--figures=false", "--estimators=",
       "--sample_time=0.5", "--order=20", "--duration=300", "--step_time=150",
       "--window=100", "--response_horizon=40", "--lambda_grid_step=1e-4",
       "--conversion_duration=1000", "--selection=paper"},
      "");
  ASSERT_TRUE(reproduced.ok());
  ASSERT_EQ(reproduced->exit_code, 0) << reproduced->err;
  const nlohmann::json results =
      ParsedJson(scratch_ / "reproduced/results.json")["cases"][0]["runs"];
  const auto column = [&](const std::string& name) {
    return std::find(runs[0].begin(), runs[0].end(), name) - runs[0].begin();
  };
  ASSERT_EQ(runs.size(), 3U);
  for (int seed = 0; seed < 2; ++seed) {
    const auto value = [&](const std::string& name) {
      return std::stod(runs[seed + 1][column(name)]);
    };
    EXPECT_EQ(value("E"), results[seed]["E_star"]);
    EXPECT_EQ(value("E_zero"), results[seed]["E_zero"]);
    EXPECT_EQ(value("E_best"), results[seed]["E_oracle"]);
    EXPECT_EQ(value("lambda_min"), results[seed]["lambda_star"]);
    EXPECT_EQ(value("lambda_best"), results[seed]["lambda_oracle"]);
    EXPECT_EQ(value("relative_gap"), results[seed]["max_relative_duality_gap"]);
  }
}

TEST_F(MleStudyTest, AFailedRunIsARow) {
  nlohmann::json campaign = SmallCampaign(2);
  // With gains 40 times as large the loop diverges.
  campaign["mismatches"].push_back(
      {{"name", "wild"}, {"changes", {{{"gain_factor", 40}}}}});
  const auto runs = ParsedCsv(Run(campaign, "out") + "/runs.csv");
  EXPECT_EQ(result_.exit_code, 0) << result_.err;
  EXPECT_THAT(result_.err, HasSubstr("warning: 2 of 6 runs: failed"));
  ASSERT_EQ(runs.size(), 7U);
  for (int run = 0; run < 6; ++run) {
    const std::string& status = runs[run + 1].back();
    if (run < 4) {
      EXPECT_EQ(status, "ok");
    } else {
      EXPECT_THAT(status, HasSubstr("failed: the closed loop"));
    }
  }
  const nlohmann::json summary = ParsedJson(scratch_ / "out/summary.json");
  EXPECT_EQ(summary["failed"], 2);
  EXPECT_EQ(summary["cells"][2]["failed"], 2);
}

TEST_F(MleStudyTest, ExitCodeOneIfNothingSucceeded) {
  nlohmann::json campaign = SmallCampaign(1);
  campaign["mismatches"] = {
      {{"name", "wild"}, {"changes", {{{"gain_factor", 40}}}}}};
  Run(campaign, "out", {"--figures=true"});
  EXPECT_EQ(result_.exit_code, 1);
  EXPECT_THAT(Content(scratch_ / "out/report.html"),
              HasSubstr("failed: the closed loop"));
}

// Where the first line has that name.
std::size_t Column(const std::vector<std::vector<std::string>>& csv,
                   const std::string& name) {
  const auto found = std::find(csv[0].begin(), csv[0].end(), name);
  EXPECT_NE(found, csv[0].end()) << name;
  return static_cast<std::size_t>(found - csv[0].begin());
}

TEST_F(MleStudyTest, ADryRunWritesNothing) {
  Run(SmallCampaign(7), "out", {"--dry_run"});
  EXPECT_EQ(result_.exit_code, 0) << result_.err;
  EXPECT_THAT(result_.out, HasSubstr("14 runs"));
  EXPECT_THAT(result_.out, HasSubstr("\n9,column,0.001,0,"));
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out"));
}

TEST_F(MleStudyTest, RandomPlantsAndSequencesOfChanges) {
  nlohmann::json campaign = SmallCampaign(3);
  campaign["models"].push_back(
      {{"name", "random"},
       {"random", {{"time_constant", {4, 8}}, {"delay", {0.5, 2}}}}});
  campaign["mismatches"] = {
      {{"name", "one"},
       {"changes", {{{"elements", 1}, {"gain_factor", {0.5, 0.7}}}}}}};
  campaign["windows"] = {
      {{"name", "3"}, {"changes", 3}, {"window", 60}, {"spacing", 130}}};
  const auto runs = ParsedCsv(Run(campaign, "out") + "/runs.csv");
  EXPECT_EQ(result_.exit_code, 0) << result_.err;
  ASSERT_EQ(runs.size(), 7U);
  // Every seed another plant: E before correction differs.
  EXPECT_NE(runs[4][Column(runs, "E_initial")],
            runs[5][Column(runs, "E_initial")]);
  EXPECT_NE(runs[5][Column(runs, "E_initial")],
            runs[6][Column(runs, "E_initial")]);
  for (std::size_t i = 1; i < runs.size(); ++i) {
    EXPECT_EQ(runs[i].back(), "ok");
    EXPECT_LT(std::stod(runs[i][Column(runs, "E")]),
              std::stod(runs[i][Column(runs, "E_initial")]))
        << i;
  }
}

TEST_F(MleStudyTest, TheElasticNetGoesFromTheLassoOn) {
  nlohmann::json campaign = SmallCampaign(1);
  campaign["lambda_grid"] = {{"min", 1e-5}, {"max", 1e-2}, {"count", 16}};
  campaign["solvers"] = {"homotopy",
                         {{"name", "lasso again"}, {"elastic_net", 1.0}},
                         {{"name", "half"}, {"elastic_net", 0.5}}};
  const auto runs = ParsedCsv(Run(campaign, "out") + "/runs.csv");
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  ASSERT_EQ(runs.size(), 7U);
  // At ratio 1 it is the lasso, but for the path between the λ of the grid,
  // which decides nothing here: λ and E are of the grid.
  EXPECT_EQ(runs[1][Column(runs, "lambda_min")],
            runs[2][Column(runs, "lambda_min")]);
  EXPECT_NEAR(std::stod(runs[1][Column(runs, "E")]) /
                  std::stod(runs[2][Column(runs, "E")]),
              1.0, 1e-6);
  EXPECT_NE(runs[1][Column(runs, "E")], runs[3][Column(runs, "E")]);
}

// Two methods, and more cells than a table shows before its fold is opened.
TEST_F(MleStudyTest, ThePageIsReadable) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  nlohmann::json campaign = SmallCampaign(2);
  campaign["mismatches"][0]["sizes"] = {0.25, 0.5, 1};
  campaign["noise_variances"] = {1e-4, 1e-3, 1e-2};
  campaign["selections"] = {"paper", "blocks"};
  Run(campaign, "out", {"--figures=true"});
  ASSERT_EQ(result_.exit_code, 0) << result_.err;
  const std::string html = Content(scratch_ / "out/report.html");
  const PageTable methods = TableOf(html, "Methods over all scenarios");
  ASSERT_EQ(methods.rows.size(), 1u + 2u);
  EXPECT_EQ(methods.rows[1][1], "12");
  EXPECT_THAT(html, HasSubstr("The other 4 of 24 cells"));
  // A sweep of three noises for four mismatches, and six panels of E.
  ExpectReadable(scratch_ / "out/report.html", "study_many", 10,
                 {.badge = "closer"});
  ExpectFitsPaper(scratch_ / "out/report.html", "study_paper");
}

}  // namespace
}  // namespace mle
