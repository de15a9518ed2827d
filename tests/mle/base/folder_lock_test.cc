#include "mle/base/folder_lock.h"

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/version.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

class FolderLockTest : public ::testing::Test {
 protected:
  const ScratchFolder scratch_;
  const std::string folder_ = scratch_.path();
};

TEST_F(FolderLockTest, IsHeldByOneAtATime) {
  auto first = FolderLock::Take(folder_);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = FolderLock::Take(folder_);
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()), HasSubstr(folder_));
  {
    const FolderLock moved = *std::move(first);
    EXPECT_FALSE(FolderLock::Take(folder_).ok());
  }
  EXPECT_TRUE(FolderLock::Take(folder_).ok());
}

TEST_F(FolderLockTest, LeavesNothingBehind) {
  { EXPECT_TRUE(FolderLock::Take(folder_).ok()); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(FolderLockTest, NeedsAFolder) {
  const auto missing = FolderLock::Take(folder_ + "/none");
  EXPECT_TRUE(absl::IsNotFound(missing.status())) << missing.status();
  EXPECT_FALSE(FolderLock::Take("/dev/null").ok());
}

TEST(VersionTest, IsThatOfTheProject) {
  EXPECT_EQ(LibraryVersion(), MLE_PROJECT_VERSION);
}

}  // namespace
}  // namespace mle
