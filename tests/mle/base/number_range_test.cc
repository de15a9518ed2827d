#include "mle/base/number_range.h"

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
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

TEST(NumberRangeTest, SampleTimesHaveRates) {
  for (const double sample_time : {1e-300, 0.2, 1e300}) {
    EXPECT_TRUE(ValidateSampleTime("Δt", sample_time).ok()) << sample_time;
  }
  for (const double sample_time : {0.0, -1.0, kNaN, -kInfinity}) {
    EXPECT_EQ(ValidateSampleTime("Δt", sample_time).message(),
              absl::StrCat("Δt is ", sample_time, ", must be positive"));
  }
  for (const double sample_time : {5e-324, 1e301, kInfinity}) {
    EXPECT_THAT(std::string(ValidateSampleTime("Δt", sample_time).message()),
                testing::HasSubstr("must be in [1e-300, 1e+300]"));
  }
}

}  // namespace
}  // namespace mle
