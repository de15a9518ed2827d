#include <iterator>
#include <set>
#include <string>

#include "apps/lifecycle/policy.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::lifecycle {
namespace {

using ::testing::HasSubstr;

Policy Parsed(const std::string& name) { return ParsePolicies(name)->front(); }

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
  const char* const all[] = {"never",   "perfect",       "output_error:1",
                             "arx:1",   "test:1",        "on_demand:0.7",
                             "test:12", "output_error:2"};
  for (const char* const name : all) {
    names.insert(ShortName(Parsed(name)));
    instructions.insert(Instruction(Parsed(name)));
  }
  EXPECT_EQ(names.size(), std::size(all));
  EXPECT_EQ(instructions.size(), std::size(all));
}

TEST(PolicyWordsTest, DescriptionsSayWhen) {
  EXPECT_THAT(Description(Parsed("output_error:3")),
              HasSubstr("after every 3rd set-point change"));
  EXPECT_THAT(Description(Parsed("test:12")), HasSubstr("every 12 months"));
  EXPECT_THAT(Description(Parsed("on_demand:0.5")), HasSubstr("below 0.5"));
  EXPECT_THAT(Description(Parsed("perfect")), HasSubstr("the reference"));
}

}  // namespace
}  // namespace mle::lifecycle
