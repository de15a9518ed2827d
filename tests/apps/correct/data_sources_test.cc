#include "apps/correct/data_sources.h"

#include <sys/stat.h>

#include <string>

#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::correct {
namespace {

absl::StatusOr<DataFile> ReadText(const std::string& content) {
  const ScratchFolder folder;
  return ReadDataFile(folder.Write("checksum.bin", content));
}

// FIPS 180-4's own examples.
TEST(DataSourcesTest, KnownDigests) {
  EXPECT_EQ(ReadText("abc")->sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(ReadText("")->sha256,
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const auto million = ReadText(std::string(1'000'000, 'a'));
  EXPECT_EQ(million->sha256,
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(million->bytes, 1'000'000);
}

TEST(DataSourcesTest, FilesThatAreNotThereAreNamed) {
  const auto missing = ReadDataFile("/no/such/file");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.status().message().find("/no/such/file"),
            std::string::npos);
}

// A pipe that nobody writes to, and devices that do not end.
TEST(DataSourcesTest, WhatIsNoFileIsNotRead) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path :
       {pipe, std::string("/dev/zero"), std::string("/dev/full")}) {
    const auto checksum = ReadDataFile(path);
    ASSERT_FALSE(checksum.ok());
    EXPECT_NE(checksum.status().message().find(path), std::string::npos);
    EXPECT_NE(checksum.status().message().find("regular file"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace mle::correct
