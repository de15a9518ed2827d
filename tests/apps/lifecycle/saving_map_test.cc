#include <cmath>

#include "apps/lifecycle/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::lifecycle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PolicySummary Policy(const std::string& policies, double saving,
                     double half_width, int ran_away = 0) {
  PolicySummary policy;
  policy.policy = ParsePolicies(policies)->front();
  policy.saving = {saving, half_width};
  policy.ran_away = ran_away;
  return policy;
}

RateSummary Rate(double rate, std::vector<PolicySummary> policies) {
  policies.insert(policies.begin(), Policy("never", 0.0, 0.0));
  return {.rate = rate, .policies = std::move(policies), .break_even = {}};
}

TEST(SavingMapTest, ShadesWhatPaysAndSaysWhatEachSaves) {
  const RateSummary slow = Rate(0.5, {Policy("output_error:3", 49.4, 143.0),
                                      Policy("test:12", -24736.0, 2924.0)});
  const RateSummary fast = Rate(1.0, {Policy("output_error:3", 8416.0, 1130.0),
                                      Policy("test:12", 4208.0, 100.0)});
  const RateSummary faster = Rate(2.0, {Policy("output_error:3", 90000.0, 10.0),
                                        Policy("test:12", 22500.0, 10.0)});
  const report::NamedFigure map = SavingMap({&slow, &fast, &faster}, "EUR");
  ASSERT_TRUE(map.figure.Validate().ok());
  EXPECT_THAT(map.caption, HasSubstr(", EUR"));
  EXPECT_FALSE(map.alt.empty());
  const report::Panel& panel = map.figure.panels.front();
  EXPECT_THAT(panel.x.names, ElementsAre("0.5", "1", "2"));
  EXPECT_THAT(panel.y.names, ElementsAre("step test every 12 months",
                                         "corrected every 3rd change"));
  ASSERT_EQ(panel.cells.size(), 6u);
  // From the bottom: tests at all rates, then corrections.
  EXPECT_EQ(panel.cells[0].shade, 0.0);
  EXPECT_THAT(panel.cells[0].lines, ElementsAre("−24,736", "± 2,924"));
  EXPECT_EQ(panel.cells[1].shade, 0.5);
  EXPECT_EQ(panel.cells[2].shade, 0.25);  // Of the most saved at that rate.
  EXPECT_EQ(panel.cells[3].shade, 0.0);   // Within its interval of zero.
  EXPECT_EQ(panel.cells[4].shade, 1.0);
  EXPECT_THAT(panel.cells[4].lines, ElementsAre("+8,416", "± 1,130"));
}

TEST(SavingMapTest, OneSeedHasNoIntervals) {
  const RateSummary rate = Rate(1.0, {Policy("output_error", 500.0, kNaN),
                                      Policy("on_demand:0.7", kNaN, kNaN, 1),
                                      Policy("perfect", kNaN, kNaN)});
  const report::NamedFigure map = SavingMap({&rate}, "");
  ASSERT_TRUE(map.figure.Validate().ok());
  const auto& cells = map.figure.panels.front().cells;
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_THAT(cells[0].lines, ElementsAre("–"));
  EXPECT_THAT(cells[1].lines, ElementsAre("the loop diverged"));
  EXPECT_THAT(cells[2].lines, ElementsAre("+500"));
  EXPECT_EQ(cells[2].shade, 1.0);
}

TEST(SavingMapTest, NothingSavedLeavesTheMapWhite) {
  const RateSummary rate = Rate(0.0, {Policy("output_error", 0.0, 0.0)});
  const report::NamedFigure map = SavingMap({&rate}, "");
  EXPECT_EQ(map.figure.panels.front().cells.front().shade, 0.0);
}

}  // namespace
}  // namespace mle::lifecycle
