#include "apps/common/command_line.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseNumbers, OneValueServesAllChannels) {
  const absl::StatusOr<Eigen::VectorXd> numbers =
      ParseNumbers("output_weight", "0.25", 3);
  ASSERT_TRUE(numbers.ok()) << numbers.status();
  EXPECT_THAT(*numbers, ElementsAre(0.25, 0.25, 0.25));
}

TEST(ParseNumbers, OrEachChannelHasItsOwn) {
  const absl::StatusOr<Eigen::VectorXd> numbers =
      ParseNumbers("output_weight", " 1, -2.5,3e2", 3);
  ASSERT_TRUE(numbers.ok()) << numbers.status();
  EXPECT_THAT(*numbers, ElementsAre(1.0, -2.5, 300.0));
}

TEST(ParseNumbers, ErrorsNameFlagValueAndWhatIsNeeded) {
  for (const char* value :
       {"", "a", "1,,2", "1,2,", "nan", "1,inf", "0.2 0.3"}) {
    const absl::Status status = ParseNumbers("move_weight", value, 3).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << value;
    EXPECT_THAT(std::string(status.message()),
                HasSubstr(std::string("--move_weight=") + value));
  }
  const absl::Status status = ParseNumbers("move_weight", "1,2", 3).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("2 values"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("3 channels"));
}

TEST(Fail, PrintsTheMessageAndTellsBadInputFromABadResult) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(Fail(absl::InvalidArgumentError("no such case")), 2);
  EXPECT_EQ(Fail(absl::NotFoundError("no such file")), 2);
  EXPECT_EQ(Fail(absl::FailedPreconditionError("the loop diverges")), 1);
  EXPECT_EQ(Fail(absl::InternalError("the disk is full")), 1);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "error: no such case\nerror: no such file\n"
            "error: the loop diverges\nerror: the disk is full\n");
}

}  // namespace
}  // namespace mle
