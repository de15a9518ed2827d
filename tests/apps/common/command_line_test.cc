#include "apps/common/command_line.h"

#include "gtest/gtest.h"

namespace mle {
namespace {

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
