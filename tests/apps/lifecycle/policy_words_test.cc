#include <iterator>
#include <set>
#include <string>

#include "apps/lifecycle/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/lifecycle/small_scenario.h"

namespace mle::lifecycle {
namespace {

using ::testing::HasSubstr;

Policy Parsed(const std::string& name) { return ParsePolicies(name)->front(); }

// In hours, changes a month apart.
Campaign MonthlyChanges() {
  Campaign campaign;
  campaign.model = testing::Tank();
  campaign.life.month = 730.0;
  campaign.set_points.change_every = 730.0;
  campaign.life.test = {
      .hold = 6.0, .cycles = 2, .move = Eigen::VectorXd::Ones(1)};
  return campaign;
}

TEST(PolicyWordsTest, OrdinalsAreEnglish) {
  EXPECT_EQ(ShortName(Parsed("output_error:1")), "corrected every change");
  EXPECT_EQ(ShortName(Parsed("output_error:2")), "corrected every 2nd change");
  EXPECT_EQ(ShortName(Parsed("output_error:3")), "corrected every 3rd change");
  EXPECT_EQ(ShortName(Parsed("output_error:12")),
            "corrected every 12th change");
  EXPECT_EQ(ShortName(Parsed("output_error:21")),
            "corrected every 21st change");
  EXPECT_EQ(ShortName(Parsed("output_error:113")),
            "corrected every 113th change");
}

// Tables and legends tell policies apart by these names.
TEST(PolicyWordsTest, EveryPolicyHasAnotherName) {
  std::set<std::string> names, instructions;
  const char* const all[] = {"never",         "perfect", "output_error:1",
                             "combined:1",    "arx:1",   "test:1",
                             "on_demand:0.7", "test:12", "output_error:2"};
  for (const char* const name : all) {
    names.insert(ShortName(Parsed(name)));
    instructions.insert(Instruction(Parsed(name)));
  }
  EXPECT_EQ(names.size(), std::size(all));
  EXPECT_EQ(instructions.size(), std::size(all));
}

TEST(PolicyWordsTest, DescriptionsSayWhen) {
  const Campaign campaign = MonthlyChanges();
  EXPECT_THAT(Description(Parsed("output_error:3"), campaign, 1.0),
              HasSubstr("every 3rd set-point change, about every 3 months"));
  // Up and back, twice, for 6 hours each.
  EXPECT_THAT(Description(Parsed("test:12"), campaign, 1.0),
              HasSubstr("off for 24 hours"));
  EXPECT_THAT(Description(Parsed("test:12"), campaign, 1.0 / 24.0),
              HasSubstr("off for 1 hour,"));
  EXPECT_THAT(Description(Parsed("on_demand:0.5"), campaign, 1.0),
              HasSubstr("more than 2 times"));
  EXPECT_THAT(Description(Parsed("perfect"), campaign, 1.0),
              HasSubstr("the floor"));
}

}  // namespace
}  // namespace mle::lifecycle
