#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "apps/experiment/campaign_json.h"
#include "apps/experiment/study.h"
#include "gtest/gtest.h"
#include "tests/apps/experiment/small_campaign.h"

namespace mle::experiment {
namespace {

Campaign Made(const nlohmann::json& json) {
  return *ParseCampaign(json.dump(), "c.json");
}

// All rows of a campaign, each unit's runs in one call, or one by one.
std::map<std::int64_t, std::string> Rows(const Campaign& campaign,
                                         int unit_scenarios, bool one_by_one) {
  const Grid grid(campaign, unit_scenarios);
  const std::atomic<bool> stop{false};
  std::map<std::int64_t, std::string> rows;
  const auto keep = [&](const Outcome& outcome) {
    Row row = RowOf(outcome);
    row.seconds = 0.0;
    rows[outcome.run] = RowText(campaign, grid, row);
  };
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    const std::vector<std::int64_t> runs = grid.RunsOf(unit);
    if (!one_by_one) {
      RunUnit(campaign, grid, runs, stop, keep);
      continue;
    }
    for (const std::int64_t run : runs) {
      RunUnit(campaign, grid, {run}, stop, keep);
    }
  }
  return rows;
}

// What runs share must not show in them.
TEST(RunUnitTest, ARowDependsOnItsNumberAlone) {
  nlohmann::json json = SmallCampaign(1);
  json["estimators"] = {"arx:none", "arx:adequacy", "arx", "output_error"};
  json["selections"] = {"paper", "bic"};
  json["ablations"] = {"none", "half_windows"};
  const Campaign campaign = Made(json);
  const auto together = Rows(campaign, Grid::kUnitScenarios, false);
  EXPECT_EQ(together.size(), 2U * 2U * 7U);
  EXPECT_EQ(together, Rows(campaign, 1, true));
}

// Records have the effects; none is what it is without the axis.
TEST(RunUnitTest, EffectsChangeRecords) {
  nlohmann::json json = SmallCampaign(1);
  json["mismatches"].erase(1);
  const auto before = Rows(Made(json), Grid::kUnitScenarios, false);
  json["effects"] = nlohmann::json::parse(R"([
    {"name": "none"},
    {"name": "sine", "effects": {"outputs": [
      {"name": "top", "sines": [{"amplitude": 0.2, "period": 20}]}]}},
    {"name": "moves", "effects": {"outputs": [
      {"name": "top", "set_point": {"ramps": [[100, 20, 1.0]]}}]}},
    {"name": "compression", "effects": {"outputs": [
      {"name": "top", "archive": {"compression": 0.05}}]}}])");
  const auto rows = Rows(Made(json), Grid::kUnitScenarios, false);
  ASSERT_EQ(rows.size(), 4U);
  ASSERT_EQ(before.size(), 1U);
  EXPECT_EQ(rows.at(0), before.at(0));
  const auto rest = [](const std::string& row) {
    return row.substr(row.find(",default,"));
  };
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < a; ++b) EXPECT_NE(rest(rows.at(a)), rest(rows.at(b)));
  }
}

// Every ablation changes what comes of ΔR, and nothing else does.
TEST(RunUnitTest, AblationsDiffer) {
  nlohmann::json json = SmallCampaign(1);
  json["mismatches"].erase(1);
  json["ablations"] = {"none"};
  for (const Ablation& ablation : Ablations()) {
    json["ablations"].push_back(ablation.name);
  }
  const Campaign campaign = Made(json);
  const Grid grid(campaign);
  const std::atomic<bool> stop{false};
  std::map<int, double> E;
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    RunUnit(
        campaign, grid, grid.RunsOf(unit), stop, [&](const Outcome& outcome) {
          ASSERT_TRUE(outcome.evaluation.ok()) << outcome.evaluation.status();
          E[outcome.at.scenario.ablation] = outcome.evaluation->E();
        });
  }
  ASSERT_EQ(E.size(), campaign.ablations.size());
  for (std::size_t i = 1; i < E.size(); ++i) {
    EXPECT_NE(E[static_cast<int>(i)], E[0]) << campaign.ablations[i]->name;
  }
}

// The model left alone has E(M, G₀), and no test or λ.
TEST(RunUnitTest, NoEstimatorLeavesTheModel) {
  nlohmann::json json = SmallCampaign(1);
  json["estimators"] = {"none", "output_error"};
  const Campaign campaign = Made(json);
  const Grid grid(campaign);
  const std::atomic<bool> stop{false};
  RunUnit(campaign, grid, grid.RunsOf(0), stop, [&](const Outcome& outcome) {
    const Row row = RowOf(outcome);
    ASSERT_TRUE(row.ok()) << row.status;
    if (!campaign.methods[outcome.at.method].estimator.has_value()) {
      EXPECT_EQ(row[Metric::kE], row[Metric::kInitialE]);
      EXPECT_TRUE(std::isnan(row[Metric::kPValue]));
      EXPECT_TRUE(std::isnan(row[Metric::kLimitE]));
      return;
    }
    // The mismatches are far beyond the noise.
    EXPECT_LT(row[Metric::kE], row[Metric::kInitialE]);
    EXPECT_EQ(row[Metric::kProposed], 1.0);
    EXPECT_EQ(row[Metric::kNamed], 1.0);
    EXPECT_GT(row[Metric::kLimitE], 0.0);
    EXPECT_GE(row[Metric::kCovered], 0.0);
    EXPECT_LE(row[Metric::kCovered], 1.0);
  });
}

// Outliers ruin both estimators; judged by a model they cost little.
TEST(RunUnitTest, OutliersAreFoundByTheModel) {
  nlohmann::json json = SmallCampaign(1);
  json["mismatches"].erase(1);
  json["estimators"] = {"arx:none", "output_error:none"};
  nlohmann::json window = json["windows"][0];
  window["name"] = "outliers";
  window["outlier_share"] = 0.01;
  window["longest_outlier"] = 10;
  json["windows"].push_back(window);
  window["name"] = "by model";
  window["robust"] = "model";
  json["windows"].push_back(window);
  const Campaign campaign = Made(json);
  const Grid grid(campaign);
  const std::atomic<bool> stop{false};
  std::map<std::pair<int, int>, double> E;  // by method and windows
  RunUnit(campaign, grid, grid.RunsOf(0), stop, [&](const Outcome& outcome) {
    ASSERT_TRUE(outcome.evaluation.ok()) << outcome.evaluation.status();
    E[{outcome.at.method, outcome.at.scenario.windows}] =
        outcome.evaluation->E();
  });
  ASSERT_EQ(E.size(), 6U);
  for (const int method : {0, 1}) {
    EXPECT_GT((E[{method, 1}]), 5.0 * (E[{method, 0}])) << method;
    EXPECT_LT((E[{method, 2}]), 3.0 * (E[{method, 0}])) << method;
  }
}

TEST(RunUnitTest, StartsNothingOnceStopped) {
  const Campaign campaign = Made(SmallCampaign(1));
  const Grid grid(campaign);
  std::atomic<bool> stop{true};
  int runs = 0;
  RunUnit(campaign, grid, grid.RunsOf(0), stop,
          [&](const Outcome&) { ++runs; });
  EXPECT_EQ(runs, 0);
  stop = false;
  RunUnit(campaign, grid, grid.RunsOf(0), stop, [&](const Outcome&) {
    ++runs;
    stop = true;
  });
  EXPECT_EQ(runs, 1);
}

}  // namespace
}  // namespace mle::experiment
