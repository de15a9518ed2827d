#include <string>

#include "apps/lifecycle/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::lifecycle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PolicySummary Costing(const std::string& name, const MeanOfSeeds& excess) {
  PolicySummary policy;
  policy.policy = ParsePolicies(name)->front();
  policy.cost = {excess.mean + 1000.0, 500.0};
  policy.excess = excess;
  return policy;
}

TEST(CostFigureTest, ShowsMeansAndIntervalsAboveTheReference) {
  RateSummary rate;
  rate.policies = {
      Costing("never", {400.0, 40.0}), Costing("output_error:3", {100.0, 20.0}),
      Costing("perfect", {0.0, 0.0}), Costing("test:12", {30000.0, 100.0})};
  const report::NamedFigure named = CostFigure(rate, "EUR");
  ASSERT_TRUE(named.figure.Validate().ok());
  const report::Panel& panel = named.figure.panels.front();
  // From the bottom: the dearest first.
  EXPECT_THAT(panel.y.names,
              ElementsAre("step test every 12 months", "never updated",
                          "corrected every 3rd change"));
  EXPECT_THAT(panel.x.label, HasSubstr("above the reference, EUR"));
  ASSERT_EQ(panel.series.size(), 3u);
  EXPECT_THAT(panel.series[2].x, ElementsAre(80.0, 120.0));
  EXPECT_THAT(panel.series[2].y, ElementsAre(2.0, 2.0));
  EXPECT_EQ(panel.markers[2].x, 100.0);
  // The reference is a line at zero with its name.
  ASSERT_EQ(panel.lines.size(), 1u);
  EXPECT_EQ(panel.lines[0].value, 0.0);
  EXPECT_EQ(panel.lines[0].label, kReferenceLabel);
  // Tests that cost many times as much are shown as beyond.
  ASSERT_TRUE(panel.x.range.has_value());
  EXPECT_LT(panel.x.range->max, 1000.0);
  EXPECT_EQ(panel.markers[0].x, panel.x.range->max);
  EXPECT_EQ(panel.markers[0].label, "beyond the right edge");
  EXPECT_EQ(panel.markers[1].label, "");
}

TEST(CostFigureTest, WithoutPerfectAndIntervalsCostsAreWhole) {
  RateSummary rate;
  rate.policies = {Costing("never", {kNaN, kNaN}),
                   Costing("output_error:1", {kNaN, kNaN})};
  rate.policies[0].cost = {400.0, kNaN};
  rate.policies[1].cost = {kNaN, kNaN};  // Its loop diverged.
  const report::NamedFigure named = CostFigure(rate, "");
  ASSERT_TRUE(named.figure.Validate().ok());
  const report::Panel& panel = named.figure.panels.front();
  EXPECT_EQ(panel.x.label, "cost a year");
  EXPECT_THAT(panel.y.names, ElementsAre("never updated"));
  EXPECT_THAT(panel.series.at(0).x, ElementsAre(400.0, 400.0));
  EXPECT_TRUE(panel.lines.empty());
}

}  // namespace
}  // namespace mle::lifecycle
