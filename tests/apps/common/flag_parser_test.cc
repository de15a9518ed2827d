#include "apps/common/flag_parser.h"

#include <string>
#include <vector>

#include "gflags/gflags.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"

DEFINE_int32(test_count, 1, "");
DEFINE_uint64(test_seed, 1, "");
DEFINE_double(test_length, 0.1, "");
DEFINE_string(test_name, "none", "");
DEFINE_bool(test_switch, false, "");

namespace mle {
namespace {

using ::testing::HasSubstr;

class FlagParser : public ::testing::Test {
 protected:
  absl::Status Parse(const std::vector<std::string>& arguments) {
    return ParseFlags(arguments, parsed_);
  }

  void ExpectError(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& parts) {
    const absl::Status status = Parse(arguments);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    for (const std::string& part : parts) {
      EXPECT_THAT(std::string(status.message()), HasSubstr(part));
    }
  }

  ParsedFlags parsed_;
  gflags::FlagSaver saver_;  // puts all flags back
};

TEST_F(FlagParser, ReadsEveryKindOfFlag) {
  ASSERT_TRUE(
      Parse({"--test_count=-7", "--test_seed=18446744073709551615",
             "--test_length=1e-6", "--test_name=a=b c", "--test_switch=true"})
          .ok());
  EXPECT_EQ(FLAGS_test_count, -7);
  EXPECT_EQ(FLAGS_test_seed, 18446744073709551615u);
  EXPECT_EQ(FLAGS_test_length, 1e-6);
  EXPECT_EQ(FLAGS_test_name, "a=b c");
  EXPECT_TRUE(FLAGS_test_switch);
  EXPECT_FALSE(parsed_.help);
  EXPECT_FALSE(parsed_.version);
}

TEST_F(FlagParser, AcceptsTheUsualSpellings) {
  ASSERT_TRUE(
      Parse({"-test_count", "-7", "--test_switch", "--test_name="}).ok());
  EXPECT_EQ(FLAGS_test_count, -7);
  EXPECT_EQ(FLAGS_test_name, "");
  EXPECT_TRUE(FLAGS_test_switch);
  ASSERT_TRUE(Parse({"--notest_switch"}).ok());
  EXPECT_FALSE(FLAGS_test_switch);
}

TEST_F(FlagParser, LaterFlagsWin) {
  ASSERT_TRUE(Parse({"--test_count=2", "--test_count=3"}).ok());
  EXPECT_EQ(FLAGS_test_count, 3);
}

TEST_F(FlagParser, AFlagThatIsGivenIsNoDefault) {
  EXPECT_TRUE(gflags::GetCommandLineFlagInfoOrDie("test_name").is_default);
  ASSERT_TRUE(Parse({"--test_name=none"}).ok());
  EXPECT_FALSE(gflags::GetCommandLineFlagInfoOrDie("test_name").is_default);
}

TEST_F(FlagParser, KnowsHelpAndVersion) {
  ASSERT_TRUE(Parse({"--version"}).ok());
  EXPECT_TRUE(parsed_.version);
  EXPECT_FALSE(parsed_.help);
  for (const char* help : {"-h", "--help", "--helpshort"}) {
    parsed_.help = false;
    ASSERT_TRUE(Parse({help}).ok());
    EXPECT_TRUE(parsed_.help) << help;
    EXPECT_EQ(parsed_.help_topic, "");
  }
  ASSERT_TRUE(Parse({"--help=all"}).ok());
  EXPECT_EQ(parsed_.help_topic, "all");
}

TEST_F(FlagParser, ErrorsNameTheFlagAndWhatIsRight) {
  ExpectError({"--test_cont=1"}, {"--test_cont", "no such flag"});
  ExpectError({"--test_cont=1"}, {"did you mean 'test_count'?"});
  ExpectError({"--notest_count"}, {"--notest_count", "no such flag"});
  ExpectError({"stray"}, {"'stray'", "--"});
  ExpectError({"---test_count=1"}, {"---test_count"});
  ExpectError({"-"}, {"'-'"});
  ExpectError({""}, {"''"});
  ExpectError({"--test_count"}, {"--test_count", "needs a value"});
  ExpectError({"--test_count="}, {"--test_count", "whole number"});
  ExpectError({"--test_count=1.5"}, {"--test_count=1.5", "whole number"});
  ExpectError({"--test_count=2147483648"}, {"2147483647"});
  ExpectError({"--test_seed=-1"}, {"--test_seed=-1", "from 0"});
  ExpectError({"--test_length=1m"}, {"--test_length=1m", "not a number"});
  ExpectError({"--test_switch=si"}, {"--test_switch=si", "true nor false"});
}

class FlagFile : public FlagParser {
 protected:
  const ScratchFolder folder_;
};

TEST_F(FlagFile, IsReadInItsPlace) {
  const std::string file = folder_.Write(
      "flags", "# comment\r\n\r\n  --test_count=5\r\n--test_name=a b");
  ASSERT_TRUE(Parse({"--test_count=4", "--flagfile=" + file}).ok());
  EXPECT_EQ(FLAGS_test_count, 5);
  EXPECT_EQ(FLAGS_test_name, "a b");
  ASSERT_TRUE(Parse({"--flagfile", file, "--test_count=6"}).ok());
  EXPECT_EQ(FLAGS_test_count, 6);
}

TEST_F(FlagFile, MayNameAnother) {
  const std::string inner = folder_.Write("inner", "--test_count=8\n");
  const std::string outer =
      folder_.Write("outer", "--flagfile=" + inner + "\n");
  ASSERT_TRUE(Parse({"--flagfile=" + outer}).ok());
  EXPECT_EQ(FLAGS_test_count, 8);
}

TEST_F(FlagFile, ErrorsNameItsLine) {
  const std::string unknown =
      folder_.Write("unknown", "--test_count=5\n--test_cont=5\n");
  ExpectError({"--flagfile=" + unknown}, {unknown + ":2", "--test_cont"});
  const std::string bare = folder_.Write("bare", "\ntest_count=5\n");
  ExpectError({"--flagfile=" + bare}, {bare + ":2", "'test_count=5'"});
  const std::string self =
      folder_.Write("self", "--flagfile=" + (folder_ / "self\n"));
  ExpectError({"--flagfile=" + self}, {self, "deep"});
  ExpectError({"--flagfile=" + (folder_ / "none")}, {"--flagfile", "none"});
  ExpectError({"--flagfile=" + folder_.path()}, {"--flagfile", "folder"});
}

}  // namespace
}  // namespace mle
