#include "mle/base/number_range.h"

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

TEST(NumberRangeTest, BoundsAreInclusiveUnlessOpen) {
  EXPECT_TRUE(Between(0.0, 1.0).Contains(0.0));
  EXPECT_TRUE(Between(0.0, 1.0).Contains(1.0));
  EXPECT_FALSE(kPositive.Contains(0.0));
  const NumberRange open_above{.min = 0.0, .max = 1.0, .open_max = true};
  EXPECT_TRUE(open_above.Contains(0.0));
  EXPECT_FALSE(open_above.Contains(1.0));
}

TEST(NumberRangeTest, OnlyFiniteNumbersUnlessItSaysSo) {
  for (const double value : {kInfinity, -kInfinity, kNaN}) {
    EXPECT_FALSE(kAnyNumber.Contains(value)) << value;
  }
  const NumberRange infinite{.min = 0.0, .infinite = true};
  EXPECT_TRUE(infinite.Contains(kInfinity));
  EXPECT_FALSE(infinite.Contains(-kInfinity));
  EXPECT_FALSE(infinite.Contains(kNaN));
}

TEST(NumberRangeTest, DescribesItself) {
  EXPECT_EQ(kAnyNumber.Describe(), "");
  EXPECT_EQ(kPositive.Describe(), "> 0");
  EXPECT_EQ(AtLeast(2).Describe(), "≥ 2");
  EXPECT_EQ(NumberRange{.max = 0.5}.Describe(), "≤ 0.5");
  EXPECT_EQ(Between(100, 10'000'000).Describe(), "in [100, 10000000]");
  EXPECT_EQ((NumberRange{.min = 0.0, .max = 1.0, .open_min = true}.Describe()),
            "in (0, 1]");
}

}  // namespace
}  // namespace mle
