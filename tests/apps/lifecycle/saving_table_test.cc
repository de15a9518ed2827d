
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

TEST(SavingTableTest, ShadesWhatPaysAndSaysWhatEachSaves) {
  const RateSummary slow = Rate(0.5, {Policy("output_error:3", 49.4, 143.0),
                                      Policy("test:12", -24736.0, 2924.0)});
  const RateSummary fast = Rate(1.0, {Policy("output_error:3", 8416.0, 1130.0),
                                      Policy("test:12", 4208.0, 100.0)});
  const RateSummary faster = Rate(2.0, {Policy("output_error:3", 90000.0, 10.0),
                                        Policy("test:12", 22500.0, 10.0)});
  const report::Table table = SavingTable({fast, slow, faster}, "EUR");
  EXPECT_THAT(table.caption, HasSubstr(", EUR"));
  EXPECT_EQ(table.columns[1].header, "rate 0.5");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_THAT(table.rows[0],
              ElementsAre("corrected every 3rd change", "+49.4 ± 143",
                          "+8,416 ± 1,130", "+90,000 ± 10.0"));
  // Within its interval of zero; of the most saved at that rate.
  EXPECT_THAT(table.levels[0], ElementsAre(0, 0, 4, 4));
  EXPECT_EQ(table.rows[1][1], "−24,736 ± 2,924");
  EXPECT_THAT(table.levels[1], ElementsAre(0, 0, 2, 1));
}

TEST(SavingTableTest, OneSeedHasNoIntervals) {
  const report::Table table =
      SavingTable({Rate(1.0, {Policy("output_error", 500.0, kNaN),
                              Policy("on_demand:0.7", kNaN, kNaN, 1),
                              Policy("perfect", kNaN, kNaN)})},
                  "");
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[0][1], "+500");
  EXPECT_EQ(table.levels[0][1], 4);
  EXPECT_EQ(table.rows[1][1], "the loop diverged");
  EXPECT_EQ(table.rows[2][1], "–");
}

TEST(SavingTableTest, NothingSavedLeavesItWithoutColour) {
  EXPECT_EQ(SavingTable({Rate(0.0, {Policy("output_error", 0.0, 0.0)})}, "")
                .levels[0][1],
            0);
}

}  // namespace
}  // namespace mle::lifecycle
