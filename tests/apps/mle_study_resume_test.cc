// Campaigns that are stopped: by kill -9, by signals, by a second command.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/experiment/small_campaign.h"
#include "tests/apps/started_command.h"

namespace mle {
namespace {

using experiment::SmallCampaign;
using ::testing::HasSubstr;

class MleStudyResumeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    campaign_ = scratch_.Write("campaign.json", SmallCampaign(20).dump());
  }

  std::vector<std::string> Arguments(const std::string& out) const {
    return {"--campaign=" + campaign_, "--out=" + scratch_ / out,
            "--figures=false", "--threads=2", "--resume"};
  }

  // Lines of the journal, its head too; 0 if there is none.
  int JournalLines(const std::string& out) const {
    const int file =
        open((scratch_ / (out + "/journal.csv")).c_str(), O_RDONLY);
    if (file < 0) return 0;
    int lines = 0;
    char block[4096];
    for (ssize_t size; (size = read(file, block, sizeof(block))) > 0;) {
      lines += static_cast<int>(std::count(block, block + size, '\n'));
    }
    close(file);
    return lines;
  }

  // Until the journal has so many lines, or the command has ended.
  void AwaitLines(const std::string& out, int lines,
                  const StartedCommand& command) const {
    command.Await([&] { return JournalLines(out) >= lines; });
  }

  const ScratchFolder scratch_;
  const std::string log_ = scratch_ / "log";
  std::string campaign_;
};

TEST_F(MleStudyResumeTest, NothingIsLostOrDoubledByKilling) {
  const report::ProcessResult whole = RunTested(Arguments("whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  int kills = 0;
  // Killed a few times, each a little later in the life of the process.
  for (int lines = 3; lines < 36; lines += 6) {
    StartedCommand command(MLE_TESTED_COMMAND, Arguments("killed"), log_);
    AwaitLines("killed", lines, command);
    usleep(static_cast<useconds_t>(1000 * (7 * lines % 20)));
    command.Send(SIGKILL);
    kills += command.ExitCode() == 128 + SIGKILL ? 1 : 0;
  }
  EXPECT_GE(kills, 3);
  const int done = JournalLines("killed") - 2;
  EXPECT_GT(done, 0);
  const report::ProcessResult rest = RunTested(Arguments("killed"));
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  for (const char* file : {"/runs.csv", "/summary.json", "/summary.csv"}) {
    EXPECT_EQ(Content(scratch_ / "killed" + file),
              Content(scratch_ / "whole" + file))
        << file;
  }
  // The journal itself: every run once.
  EXPECT_EQ(JournalLines("killed"), 2 + 40);
  std::set<std::string> runs;
  for (const auto& line : ParsedCsv(scratch_ / "killed/journal.csv")) {
    EXPECT_TRUE(runs.insert(line[0]).second) << line[0];
  }
}

TEST_F(MleStudyResumeTest, StopsCleanlyOnASignalAndSaysHowToGoOn) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string out = signal == SIGINT ? "int" : "term";
    StartedCommand command(MLE_TESTED_COMMAND, Arguments(out), log_);
    AwaitLines(out, 4, command);
    command.Send(signal);
    EXPECT_EQ(command.ExitCode(), 1);
    const std::string log = Content(log_);
    EXPECT_THAT(log, HasSubstr("Stopped: "));
    EXPECT_THAT(log, HasSubstr("--resume"));
    // Every line is whole.
    EXPECT_EQ(Content(scratch_ / out + "/journal.csv").back(), '\n');
  }
  const report::ProcessResult rest = RunTested(Arguments("int"));
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.err, HasSubstr("Going on: "));
  EXPECT_EQ(JournalLines("int"), 2 + 40);
}

TEST_F(MleStudyResumeTest, OneCommandInAFolder) {
  const StartedCommand first(MLE_TESTED_COMMAND, Arguments("out"), log_);
  AwaitLines("out", 3, first);
  first.Send(SIGSTOP);
  const report::ProcessResult second = RunTested(Arguments("out"));
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_THAT(second.err, HasSubstr("in use by another command"));
}

TEST_F(MleStudyResumeTest, RefusesWithoutResumeAndWithAnotherCampaign) {
  const report::ProcessResult first = RunTested(Arguments("out"));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::string before = Content(scratch_ / "out/runs.csv");
  const report::ProcessResult again =
      RunTested({"--campaign=" + campaign_, "--out=" + scratch_ / "out"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("--resume"));
  scratch_.Write("campaign.json", SmallCampaign(21).dump());
  const report::ProcessResult other = RunTested(Arguments("out"));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("another campaign"));
  EXPECT_EQ(Content(scratch_ / "out/runs.csv"), before);
  // With the campaign as it was: nothing to do, and the same once more.
  scratch_.Write("campaign.json", SmallCampaign(20).dump());
  const report::ProcessResult same = RunTested(Arguments("out"));
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(Content(scratch_ / "out/runs.csv"), before);
}

TEST_F(MleStudyResumeTest, AChangedDigitIsFoundAndItsRunDoneAgain) {
  const report::ProcessResult first = RunTested(Arguments("out"));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::string before = Content(scratch_ / "out/runs.csv");
  std::string journal = Content(scratch_ / "out/journal.csv");
  // A digit of the first line's status or metrics.
  const std::size_t at = journal.find(",ok,") - 3;
  journal[at] = journal[at] == '5' ? '6' : '5';
  scratch_.Write("out/journal.csv", journal);
  const report::ProcessResult again = RunTested(Arguments("out"));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("journal.csv:3: the line is damaged"));
  EXPECT_THAT(again.err, HasSubstr("39 of 40 runs are done"));
  EXPECT_EQ(Content(scratch_ / "out/runs.csv"), before);
}

TEST_F(MleStudyResumeTest, BadInput) {
  const auto refused = [&](const std::vector<std::string>& arguments,
                           const std::string& named) {
    const report::ProcessResult result = RunTested(arguments);
    EXPECT_EQ(result.exit_code, 2) << named;
    EXPECT_THAT(result.err, HasSubstr(named));
    EXPECT_EQ(result.out, "");
  };
  refused({}, "--campaign");
  refused({"--campaign=/no/such.json"}, "/no/such.json");
  refused({"--campaign=" + campaign_, "--out="}, "--out");
  refused({"--campaign=" + campaign_, "--threads=-1"}, "--threads=-1");
  refused({"--campaign=" + campaign_, "--part=3/2"}, "--part=3/2");
  refused({"--campaign=" + campaign_, "--out=/proc/x"}, "--out");
  refused({"--campaign=" + scratch_.Write("bad.json", "{"), "--dry_run"},
          "bad.json: line 1");
}

TEST_F(MleStudyResumeTest, TheSameBytesFromParts) {
  const report::ProcessResult whole = RunTested(Arguments("whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const auto part = [this](const std::string& name) {
    std::vector<std::string> arguments = Arguments("parts");
    arguments.push_back("--part=" + name);
    return RunTested(arguments);
  };
  for (const char* const name : {"1/3", "2/3", "3/3"}) {
    const report::ProcessResult result = part(name);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("without --part"));
  }
  EXPECT_EQ(JournalLines("parts/parts/1-of-3") +
                JournalLines("parts/parts/2-of-3") +
                JournalLines("parts/parts/3-of-3"),
            3 * 2 + 40);
  const report::ProcessResult all = RunTested(Arguments("parts"));
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.err, HasSubstr("40 of 40 runs are done"));
  for (const char* file : {"/runs.csv", "/summary.json", "/summary.csv"}) {
    EXPECT_EQ(Content(scratch_ / "whole" + file),
              Content(scratch_ / "parts" + file))
        << file;
  }
}

TEST_F(MleStudyResumeTest, WhatPartsLackIsRunAndForeignPartsAreRefused) {
  std::vector<std::string> second = Arguments("out");
  second.push_back("--part=2/2");
  ASSERT_EQ(RunTested(second).exit_code, 0);
  const report::ProcessResult all = RunTested(Arguments("out"));
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.err, HasSubstr("20 of 40 runs are done"));
  EXPECT_EQ(JournalLines("out"), 2 + 40);
  std::filesystem::remove(scratch_ / "out/journal.csv");
  scratch_.Write("campaign.json", SmallCampaign(21).dump());
  const report::ProcessResult other = RunTested(Arguments("out"));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("2-of-2/journal.csv:1: belongs to another"));
}

TEST_F(MleStudyResumeTest, APartAtWorkIsNotTakenOver) {
  std::vector<std::string> arguments = Arguments("out");
  arguments.push_back("--part=1/2");
  const StartedCommand part(MLE_TESTED_COMMAND, arguments, log_);
  AwaitLines("out/parts/1-of-2", 3, part);
  part.Send(SIGSTOP);
  const report::ProcessResult all = RunTested(Arguments("out"));
  EXPECT_EQ(all.exit_code, 2);
  EXPECT_THAT(all.err, HasSubstr("in use by another command"));
}

}  // namespace
}  // namespace mle
