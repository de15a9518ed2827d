#include "apps/common/option_values.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(ParseNumbersTest, ReadsAList) {
  const absl::StatusOr<Eigen::VectorXd> numbers =
      ParseNumbers(" 1, -2.5,3e2", kAnyNumber);
  ASSERT_TRUE(numbers.ok()) << numbers.status();
  EXPECT_THAT(*numbers, ElementsAre(1.0, -2.5, 300.0));
}

TEST(ParseNumbersTest, NoneStandsForTheLimitThatThereIsNot) {
  EXPECT_THAT(*ParseNumbers("none,2", kNotNegative, -7.0),
              ElementsAre(-7.0, 2.0));
  EXPECT_FALSE(ParseNumbers("none", kNotNegative).ok());
}

TEST(ParseNumbersTest, ErrorsNameThePart) {
  for (const char* text :
       {"", "a", "1,,2", "1,2,", "nan", "1,inf", "0.2 0.3"}) {
    const absl::Status status = ParseNumbers(text, kAnyNumber).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
  }
  EXPECT_THAT(std::string(ParseNumbers("1,0", kPositive).status().message()),
              HasSubstr("'0' must be > 0"));
}

TEST(FitToChannelsTest, OneValueServesAllChannels) {
  const Eigen::VectorXd one = Eigen::VectorXd::Constant(1, 0.25);
  EXPECT_THAT(*FitToChannels(one, 3), ElementsAre(0.25, 0.25, 0.25));
  EXPECT_EQ(FitToChannels(Eigen::VectorXd(), 3)->size(), 0);
  const absl::Status status =
      FitToChannels(Eigen::VectorXd::Zero(2), 3).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("2 values"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("3 channels"));
}

TEST(ParseListTest, LeavesOutBlanksAndEmptyParts) {
  EXPECT_THAT(ParseList("gain, delay,,"), ElementsAre("gain", "delay"));
  EXPECT_THAT(ParseList(" , "), IsEmpty());
  EXPECT_THAT(ParseList(""), IsEmpty());
}

}  // namespace
}  // namespace mle
