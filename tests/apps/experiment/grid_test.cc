#include "apps/experiment/grid.h"

#include <set>
#include <vector>

#include "apps/experiment/campaign_json.h"
#include "gtest/gtest.h"
#include "tests/apps/experiment/small_campaign.h"

namespace mle::experiment {
namespace {

Campaign LargeCampaign() {
  nlohmann::json json = SmallCampaign(5);
  json["noise_variances"] = {1e-4, 1e-3};
  json["drift_variances"] = {0, 1e-7, 1e-6};
  json["effects"] = {{{"name", "none"}}, {{"name", "also none"}}};
  json["ablations"] = {"none", "raw_scaling"};
  json["selections"] = {"paper", "bic"};
  json["mismatches"].push_back({{"name", "none"}});
  return *ParseCampaign(json.dump(), "c.json");
}

TEST(GridTest, UnitsHoldEveryRunOnce) {
  const Campaign campaign = LargeCampaign();
  const Grid grid(campaign);
  EXPECT_EQ(grid.num_runs(), 5 * 2 * 2 * 3 * 2 * 2 * 3);
  std::set<std::int64_t> seen;
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    const std::vector<std::int64_t> runs = grid.RunsOf(unit);
    ASSERT_FALSE(runs.empty());
    EXPECT_LE(runs.size(), 2U * Grid::kUnitScenarios);
    for (const std::int64_t run : runs) {
      EXPECT_TRUE(seen.insert(run).second) << run;
      // One conversion for all.
      const Coordinates at = grid.At(run);
      const Coordinates first = grid.At(runs.front());
      EXPECT_EQ(at.seed, first.seed);
      EXPECT_EQ(at.scenario.model, first.scenario.model);
      EXPECT_EQ(at.scenario.noise, first.scenario.noise);
      EXPECT_EQ(at.scenario.ablation, first.scenario.ablation);
    }
  }
  EXPECT_EQ(static_cast<std::int64_t>(seen.size()), grid.num_runs());
  EXPECT_EQ(*seen.begin(), 0);
  EXPECT_EQ(*seen.rbegin(), grid.num_runs() - 1);
}

TEST(GridTest, CellsDifferInTheSeedAlone) {
  const Campaign campaign = LargeCampaign();
  const Grid grid(campaign);
  std::set<std::vector<int>> seen;
  for (std::int64_t run = 0; run < grid.num_runs(); ++run) {
    const Coordinates at = grid.At(run);
    const Coordinates first = grid.At(grid.CellOf(run) * grid.seeds());
    EXPECT_EQ(at.seed, run % 5);
    EXPECT_EQ(at.method, first.method);
    EXPECT_EQ(at.scenario.mismatch, first.scenario.mismatch);
    EXPECT_EQ(at.scenario.drift, first.scenario.drift);
    EXPECT_EQ(at.scenario.effects, first.scenario.effects);
    seen.insert({at.scenario.model, at.scenario.noise, at.scenario.ablation,
                 at.scenario.drift, at.scenario.effects, at.scenario.controller,
                 at.scenario.windows, at.scenario.mismatch, at.method,
                 at.seed});
  }
  EXPECT_EQ(static_cast<std::int64_t>(seen.size()), grid.num_runs());
}

TEST(GridTest, TheFirstSeedsUnitsComeFirst) {
  const Campaign campaign = LargeCampaign();
  const Grid grid(campaign);
  int last = 0;
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    const int seed = grid.At(grid.RunsOf(unit).front()).seed;
    EXPECT_GE(seed, last);
    last = seed;
  }
}

}  // namespace
}  // namespace mle::experiment
