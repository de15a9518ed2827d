// mle_watch --serve and --acknowledge as their users call them.

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/serve/client.h"
#include "tests/apps/served_watch.h"
#include "tests/apps/watch_site.h"

namespace mle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

using WatchServerTest = WatchSite;

TEST_F(WatchServerTest, ServesWhatRunsFindUntilItIsStopped) {
  scratch_.Write("token", "0123456789abcdef0123");
  fs::permissions(scratch_ / "token", fs::perms::owner_read);
  const std::vector<std::string> arguments = {
      absl::StrCat("--controllers=", scratch_ / "controllers.json"),
      absl::StrCat("--out=", scratch_ / "watch"), "--serve=127.0.0.1:0",
      absl::StrCat("--token_file=", scratch_ / "token")};
  ServedWatch served(arguments, scratch_ / "log.txt");
  ASSERT_NE(served.port(), 0) << Content(scratch_ / "log.txt");
  EXPECT_THAT(served.Get("/"), HasSubstr("No run has looked at it yet."));
  // A run goes beside it.
  WriteDays(0, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  for (int i = 0; i < 600; ++i) {
    if (served.Get("/watch.json").find("\"aged\"") != std::string::npos) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(serve::BodyOf(served.Get("/watch.json")),
            Content(scratch_ / "watch/watch.json"));
  EXPECT_EQ(serve::BodyOf(served.Get("/")),
            Content(scratch_ / "watch/index.html"));
  const std::string id = Tank()["alarms"][0]["id"];
  EXPECT_EQ(serve::StatusOf(serve::Ask(
                served.port(),
                absl::StrCat("POST /api/v1/alarms/", id,
                             "/acknowledgement HTTP/1.1\r\nHost: localhost\r\n"
                             "Authorization: Bearer 0123456789abcdef0123\r\n"
                             "Content-Length: 14\r\n\r\n{\"who\": "
                             "\"Ann\"}"))),
            200);
  EXPECT_EQ(serve::StatusOf(serve::Ask(served.port(), "bad / HTTP\r\n\r\n")),
            400);
  EXPECT_EQ(served.Stop(SIGTERM), 0);
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["alarms"][0]["acknowledged"]["who"], "Ann");
}

TEST_F(WatchServerTest, AServerWithoutATokenIsReadOnly) {
  const std::vector<std::string> arguments = {
      absl::StrCat("--controllers=", scratch_ / "controllers.json"),
      absl::StrCat("--state=", scratch_ / "watch/state.sqlite"), "--serve=0",
      "--out=/proc"};  // where nobody can write
  ServedWatch served(arguments, scratch_ / "log.txt");
  ASSERT_NE(served.port(), 0) << Content(scratch_ / "log.txt");
  EXPECT_THAT(Content(scratch_ / "log.txt"), HasSubstr("(read-only)"));
  EXPECT_THAT(serve::Ask(served.port(),
                         "POST /acknowledge HTTP/1.1\r\nHost: localhost\r\n"
                         "Content-Type: application/x-www-form-urlencoded\r\n"
                         "Content-Length: 0\r\n\r\n"),
              HasSubstr("read-only"));
  EXPECT_EQ(served.Stop(SIGHUP), 0);
}

TEST_F(WatchServerTest, AnAlarmIsAcknowledgedOnTheCommandLine) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  const std::string id = Tank()["alarms"][0]["id"];
  const std::string out = absl::StrCat("--out=", scratch_ / "watch");
  report::ProcessResult run =
      RunTested({out, absl::StrCat("--acknowledge=", id.substr(0, 8)),
                 "--acknowledged_by=Ann", "--note=valve ordered"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(id));
  run = RunTested({out, absl::StrCat("--acknowledge=", id)});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr("Ann"));
  run = RunTested({out, "--acknowledge=zzz"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--acknowledge"));
  run = RunTested(
      {absl::StrCat("--out=", scratch_ / "other"), "--acknowledge=0"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_FALSE(fs::exists(scratch_ / "other"));
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["alarms"][0]["acknowledged"]["note"], "valve ordered");
  EXPECT_THAT(Content(scratch_ / "watch/alarms.html"), HasSubstr("by Ann at "));
}

TEST_F(WatchServerTest, AnAlarmThatWasNotTakenIsSaidOnThePages) {
  WriteDays(0, 40);
  WriteAlarmCommand("echo busy >&2; exit 3");
  EXPECT_EQ(Watch().exit_code, 1);
  EXPECT_THAT(Content(scratch_ / "watch/index.html"),
              HasSubstr("could not be handed on"));
  EXPECT_THAT(Content(scratch_ / "watch/controller-tank.html"),
              HasSubstr("command not yet (1 attempt): exit code 3: busy"));
  EXPECT_EQ(Tank()["alarms"][0]["deliveries"][0]["delivered"], false);
}

TEST_F(WatchServerTest, WrongFlagsOfTheServerAreNamed) {
  const auto run = [&](const std::vector<std::string>& more,
                       const std::vector<std::string>& variables = {}) {
    std::vector<std::string> arguments = Arguments("watch");
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunTested(arguments, variables);
  };
  EXPECT_THAT(run({"--serve=plant.example:80"}).err, HasSubstr("--serve"));
  EXPECT_THAT(run({"--serve=0", "--token_file=/none"}).err,
              HasSubstr("--token_file"));
  const report::ProcessResult weak =
      run({"--serve=0"}, {"MLE_WATCH_TOKEN=weak"});
  EXPECT_EQ(weak.exit_code, 2);
  EXPECT_THAT(weak.err, HasSubstr("MLE_WATCH_TOKEN"));
  EXPECT_THAT(run({"--serve=0", "--acknowledge=a"}).err,
              HasSubstr("--acknowledge"));
  EXPECT_THAT(run({"--alarm_mail=-oQ"}).err, HasSubstr("--alarm_mail"));
  EXPECT_THAT(run({"--alarm_webhook=x"}).err, HasSubstr("--alarm_webhook"));
}

}  // namespace
}  // namespace mle
