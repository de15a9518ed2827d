// What the commands do when the system fails them: old results stay, the
// message says what is wrong, and the exit code is 1 or 2 as for other faults.
// Runs as root too, to whom permissions are no hindrance: limits are.

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/base/folder_lock.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/started_command.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

report::ProcessResult RunProgram(const std::string& program,
                                 const std::vector<std::string>& arguments) {
  auto result = report::RunProcess(program, arguments, "");
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result)
                     : report::ProcessResult{.exit_code = -1};
}

// The command under `prlimit LIMIT`.
report::ProcessResult RunLimited(const std::string& limit,
                                 const std::vector<std::string>& arguments) {
  std::vector<std::string> line = {limit, MLE_TESTED_COMMAND};
  line.insert(line.end(), arguments.begin(), arguments.end());
  return RunProgram("prlimit", line);
}

// Sanitizers reserve terabytes of addresses: no limit can be set on them.
bool AddressesCanBeLimited() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  return false;
#else
  return true;
#endif
#else
  return true;
#endif
}

std::map<std::string, std::string> Contents(const std::string& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    contents[entry.path().filename().string()] = Content(entry.path().string());
  }
  return contents;
}

// results.json and the curves of a small run, of one case.
std::vector<std::string> Flags(const std::string& out, int seed = 1) {
  return SmallRun(out, {"--cases=gain", absl::StrCat("--first_seed=", seed)});
}

TEST(FaultsTest, AFullDiskLeavesTheOldResults) {
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  ASSERT_EQ(RunTested(Flags(out)).exit_code, 0);
  const auto before = Contents(out);
  // The limit lets small files through and stops the larger ones.
  const report::ProcessResult run =
      RunLimited("--fsize=20000", Flags(out, /*seed=*/2));
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_THAT(run.err, AllOf(HasSubstr("cannot write '" + out),
                             HasSubstr("File too large")));
  EXPECT_EQ(Contents(out), before);  // and no temporary file
}

TEST(FaultsTest, AFileSystemWithoutRoomLeavesTheOldResults) {
  const ScratchFolder scratch;
  const std::string script = scratch.Write(
      "run",
      "set -e\n"
      "mount -t tmpfs -o size=16k tmpfs \"$1\"\n"
      "echo old > \"$1/results.json\"\n"
      "shift\n"
      "code=0; \"$@\" >/dev/null || code=$?\n"
      "echo \"code $code, $(cat \"${0%run}room/results.json\"), \"$(ls -A "
      "\"${0%run}room\")\n");
  const std::string room = scratch / "room";
  ASSERT_TRUE(MakeWritableFolder(room).ok());
  std::vector<std::string> line = {"--mount", "sh", script, room,
                                   MLE_TESTED_COMMAND};
  const std::vector<std::string> flags = Flags(room);
  line.insert(line.end(), flags.begin(), flags.end());
  const report::ProcessResult run = RunProgram("unshare", line);
  if (run.out.find("code ") == std::string::npos) {
    GTEST_SKIP() << "no file system may be mounted here: " << run.err;
  }
  EXPECT_THAT(run.out, HasSubstr("code 1, old, results.json\n"));
  EXPECT_THAT(run.err, HasSubstr("No space left on device"));
}

TEST(FaultsTest, AFolderInUseIsRefused) {
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  ASSERT_TRUE(MakeWritableFolder(out).ok());
  {
    const auto lock = FolderLock::Take(out);
    ASSERT_TRUE(lock.ok()) << lock.status();
    const report::ProcessResult run = RunTested(Flags(out));
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, AllOf(HasSubstr("--out"), HasSubstr(out),
                               HasSubstr("in use by another command")));
    EXPECT_TRUE(Contents(out).empty());
  }
  EXPECT_EQ(RunTested(Flags(out)).exit_code, 0);
}

TEST(FaultsTest, AFolderInTheWayOfAFileIsFoundBeforeComputing) {
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  ASSERT_TRUE(MakeWritableFolder(out + "/results.json").ok());
  // A run that would take minutes.
  std::vector<std::string> flags = Flags(out);
  flags.insert(flags.end(), {"--seeds=10000"});
  std::vector<std::string> line = {"60", MLE_TESTED_COMMAND};
  line.insert(line.end(), flags.begin(), flags.end());
  const report::ProcessResult run = RunProgram("timeout", line);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("--out"), HasSubstr(out + "/results.json"),
                    HasSubstr("it is a folder")));
}

TEST(FaultsTest, AFolderThatTakesNoFilesIsNamed) {
  for (const char* folder : {"/proc/mle", "/dev/null/mle", "/proc"}) {
    const report::ProcessResult run = RunTested(Flags(folder));
    EXPECT_EQ(run.exit_code, 2) << folder;
    EXPECT_THAT(run.err, AllOf(HasSubstr("--out"), HasSubstr(folder)));
  }
}

TEST(FaultsTest, OutOfMemoryIsSaid) {
  if (!AddressesCanBeLimited()) GTEST_SKIP() << "under a sanitizer";
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  std::vector<std::string> flags = Flags(out);
  // 40,000 regressors: a Gram matrix of 12.8 GB.
  flags.insert(flags.end(),
               {"--order=10000", "--conversion_duration=30000", "--window=6000",
                "--duration=13000", "--step_time=6500", "--threads=1"});
  const report::ProcessResult run = RunLimited("--as=4000000000", flags);
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_THAT(run.err, HasSubstr("out of memory"));
  EXPECT_TRUE(Contents(out).empty());
}

// Whatever the limit, the command ends by itself: done, or with the message.
TEST(FaultsTest, LittleMemoryDoesNotKeepACommandFromEnding) {
  if (!AddressesCanBeLimited()) GTEST_SKIP() << "under a sanitizer";
  const ScratchFolder scratch;
  for (const int megabytes : {100, 150, 200, 250, 400}) {
    // OpenBLAS, where it is installed, interrupts a program that its threads
    // find no memory in, before the program begins.
    std::vector<std::string> line = {"60",
                                     "env",
                                     "OPENBLAS_NUM_THREADS=1",
                                     "prlimit",
                                     absl::StrCat("--as=", megabytes, "000000"),
                                     MLE_TESTED_COMMAND};
    const std::vector<std::string> flags = Flags(scratch / "out");
    line.insert(line.end(), flags.begin(), flags.end());
    const report::ProcessResult run = RunProgram("timeout", line);
    // 127: not even the program and its libraries fit.
    EXPECT_THAT(run.exit_code, ::testing::AnyOf(0, 1, 127)) << run.err;
    if (run.exit_code == 1) {
      EXPECT_THAT(run.err, HasSubstr("out of memory"));
    }
  }
}

TEST(FaultsTest, ASmallStackIsRaisedOrRefused) {
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  const report::ProcessResult raised =
      RunLimited("--stack=262144:8388608", Flags(out));
  EXPECT_EQ(raised.exit_code, 0) << raised.err;
  const report::ProcessResult refused =
      RunLimited("--stack=262144:262144", Flags(out, /*seed=*/2));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("ulimit -s"));
}

TEST(FaultsTest, OutputThatNobodyTakesIsAnError) {
  const report::ProcessResult run = RunProgram(
      "sh", {"-c", absl::StrCat(MLE_TESTED_COMMAND, " --help >/dev/full")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("cannot write to standard output"));
}

TEST(FaultsTest, WhoStopsReadingDoesNotEndTheCommand) {
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  std::string line = absl::StrCat("{ ", MLE_TESTED_COMMAND);
  for (const std::string& flag : Flags(out)) absl::StrAppend(&line, " ", flag);
  absl::StrAppend(&line, "; echo code $? >&2; } | true");
  const report::ProcessResult run = RunProgram("sh", {"-c", line});
  EXPECT_EQ(run.err, "code 0\n");
  EXPECT_THAT(Content(out + "/results.json"), HasSubstr("\"cases\""));
}

TEST(FaultsTest, AKilledCommandLeavesWholeFilesOfOneRun) {
  const ScratchFolder scratch;
  const std::string old_out = scratch / "old";
  const std::string new_out = scratch / "new";
  const std::string out = scratch / "out";
  ASSERT_EQ(RunTested(Flags(old_out)).exit_code, 0);
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(RunTested(Flags(new_out, /*seed=*/2)).exit_code, 0);
  const auto whole = std::chrono::steady_clock::now() - begin;
  const std::string old_results = Content(old_out + "/results.json");
  const std::string new_results = Content(new_out + "/results.json");
  ASSERT_NE(old_results, new_results);
  std::filesystem::copy(old_out, out);
  // Most of them around the time at which files are written.
  for (const double part : {0.1, 0.5, 0.8, 0.9, 0.95, 1.0, 1.05, 1.2}) {
    StartedCommand command(MLE_TESTED_COMMAND, Flags(out, /*seed=*/2),
                           scratch / "log");
    std::this_thread::sleep_for(part * whole);
    command.Send(SIGKILL);
    const int exit_code = command.ExitCode();
    const std::string results = Content(out + "/results.json");
    EXPECT_TRUE(results == old_results || results == new_results) << part;
    if (exit_code == 0) {
      EXPECT_EQ(results, new_results);
    } else {
      EXPECT_EQ(exit_code, 128 + SIGKILL);
    }
    // A lock does not outlive its owner.
    EXPECT_TRUE(FolderLock::Take(out).ok());
  }
  EXPECT_EQ(RunTested(Flags(out, /*seed=*/2)).exit_code, 0);
  EXPECT_EQ(Content(out + "/results.json"), new_results);
}

}  // namespace
}  // namespace mle
