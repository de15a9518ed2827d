// What mle_reproduce answers to flags and files it cannot use: exit code 2, one
// line that names the flag or file and what would be right, and no output.

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct BadInput {
  std::vector<std::string> arguments;
  std::vector<std::string> named;  // what the message must hold
};

void ExpectRefused(const std::vector<BadInput>& inputs) {
  for (const BadInput& bad : inputs) {
    const ScratchFolder scratch;
    std::vector<std::string> arguments = {"--out=" + scratch / "out"};
    arguments.insert(arguments.end(), bad.arguments.begin(),
                     bad.arguments.end());
    SCOPED_TRACE(::testing::PrintToString(bad.arguments));
    const report::ProcessResult result = RunTested(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, StartsWith("error: "));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1)
        << result.err;
    for (const std::string& name : bad.named) {
      EXPECT_THAT(result.err, HasSubstr(name));
    }
    EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
  }
}

TEST(MleReproduceBadInput, UnknownFlagsAndStrayArguments) {
  ExpectRefused({
      {{"--seed=3"}, {"--seed", "--help"}},
      {{"--nosuch"}, {"--nosuch", "--help"}},
      {{"gain"}, {"'gain'", "--help"}},
      {{"--"}, {"'--'"}},
      {{"--seeds"}, {"--seeds", "value"}},
      {{"--seeds=a\nb"}, {"--seeds=a\\nb: 'a\\nb' is not a whole number"}},
      {{"--figures=maybe"}, {"--figures=maybe", "true nor false"}},
      {{"--cases=drift"}, {"--cases", "'drift'", "gain and delay"}},
  });
}

TEST(MleReproduceBadInput, FlagFiles) {
  const ScratchFolder scratch;
  const std::string misspelled =
      scratch.Write("misspelled", "# a comment\n\n--ordr=20\n");
  const std::string bare = scratch.Write("bare", "--seeds=1\norder=20\n");
  const std::string endless = scratch.Write("endless", "");
  scratch.Write("endless", "--flagfile=" + endless + "\n");
  ExpectRefused({
      {{"--flagfile=" + scratch / "none"}, {"--flagfile", "none"}},
      {{"--flagfile=" + misspelled}, {misspelled + ":3", "--ordr"}},
      {{"--flagfile=" + bare}, {bare + ":2", "'order=20'"}},
      {{"--flagfile=" + endless}, {endless, "deep"}},
  });
}

TEST(MleReproduceBadInput, FoldersThatCannotBeWrittenTo) {
  const ScratchFolder scratch;
  const std::string file = scratch.Write("file", "here first\n");
  for (const std::string& out : {file, file + "/below", std::string()}) {
    SCOPED_TRACE(out);
    const report::ProcessResult result = RunTested({"--out=" + out});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, StartsWith("error: --out: "));
    EXPECT_THAT(result.err, HasSubstr(out));
  }
  EXPECT_EQ(Content(file), "here first\n");
}

TEST(MleReproduceBadInput, AReadOnlyFolder) {
  if (geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  const ScratchFolder scratch;
  const std::string folder = scratch / "read_only";
  ASSERT_EQ(mkdir(folder.c_str(), 0555), 0);
  const report::ProcessResult result = RunTested({"--out=" + folder});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, StartsWith("error: --out: "));
  EXPECT_THAT(result.err, HasSubstr(folder));
}

}  // namespace
}  // namespace mle
