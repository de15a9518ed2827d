// Passwords, tokens and secret addresses that mle_watch is given are in nothing
// that it writes, says or serves.

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/serve/client.h"
#include "tests/apps/served_watch.h"
#include "tests/apps/watch_site.h"
#include "tests/mle/database/postgresql_server.h"

namespace mle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// In each secret.
constexpr char kSecret[] = "geheim";
constexpr char kToken[] = "token-geheim-4712-0123";
constexpr char kHook[] = "http://127.0.0.1:1/hook-geheim-4713";

class WatchSecretsTest : public WatchSite {
 protected:
  void SetUp() override {
    if (!PostgresqlServer::IsInstalled()) GTEST_SKIP() << "no PostgreSQL";
  }
  // Of everything below the folder but what the test itself wrote.
  std::vector<std::string> FilesWithASecret() const {
    std::vector<std::string> found;
    for (const auto& entry :
         fs::recursive_directory_iterator(scratch_ / "watch")) {
      if (entry.is_regular_file() &&
          absl::StrContains(Content(entry.path().string()), kSecret)) {
        found.push_back(entry.path().string());
      }
    }
    return found;
  }
  static void ExpectNone(const std::string& text) {
    EXPECT_FALSE(absl::StrContains(text, kSecret)) << text;
  }
};

TEST_F(WatchSecretsTest, AreInNoFilePageMessageOrState) {
  const PostgresqlServer server;
  ASSERT_TRUE(server.is_running());
  server.Run("CREATE TABLE trend (time TIMESTAMP, level FLOAT8, steam FLOAT8)");
  server.Run("GRANT SELECT ON trend TO reader");
  server.Run(days_.Insert("trend", 0, 40));
  scratch_.Write(
      "controllers.json",
      absl::StrCat(R"({"version": 1, "controllers": [{"name": "tank",
        "model": "tank.json", "reference_days": 8, "records": ")",
                   server.name("reader"), R"(", "table": "trend"}]})"));
  std::vector<std::string> arguments = Arguments("watch");
  arguments[2] = "--propose=true";
  const std::string hook = absl::StrCat("MLE_WATCH_WEBHOOK=", kHook);
  const std::vector<std::string> right = {
      hook, absl::StrCat("PGPASSWORD=", PostgresqlServer::kPassword)};
  // The webhook does not answer: the fault is in state and pages.
  const report::ProcessResult run = RunTested(arguments, right);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("webhook"));
  ExpectNone(run.out + run.err);
  EXPECT_EQ(Tank()["proposals"][0]["decision"], "corrected");
  EXPECT_EQ(Tank()["alarms"][0]["deliveries"].size(), 2U);
  EXPECT_THAT(FilesWithASecret(), ::testing::IsEmpty());
  const report::ProcessResult wrong =
      RunTested(arguments, {hook, "PGPASSWORD=geheim-0815"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("password authentication failed"));
  ExpectNone(wrong.out + wrong.err);
  EXPECT_THAT(FilesWithASecret(), ::testing::IsEmpty());
}

TEST_F(WatchSecretsTest, AreServedToNobody) {
  WriteDays(0, 40);
  EXPECT_EQ(Watch().exit_code, 0);
  ::setenv("MLE_WATCH_TOKEN", kToken, 1);
  ::setenv("MLE_WATCH_WEBHOOK", kHook, 1);
  ServedWatch served(
      {absl::StrCat("--controllers=", scratch_ / "controllers.json"),
       absl::StrCat("--out=", scratch_ / "watch"), "--serve=127.0.0.1:0"},
      scratch_ / "log.txt");
  ::unsetenv("MLE_WATCH_TOKEN");
  ::unsetenv("MLE_WATCH_WEBHOOK");
  ASSERT_NE(served.port(), 0) << Content(scratch_ / "log.txt");
  for (const char* const path :
       {"/", "/alarms.html", "/controller-tank.html", "/watch.json", "/metrics",
        "/api/v1/controllers", "/api/v1/controllers/tank", "/api/v1/alarms",
        "/api/v1/controllers/tank/history", "/nothing", "/proposals/x"}) {
    ExpectNone(served.Get(path));
  }
  const std::string id = Tank()["alarms"][0]["id"];
  // Of a wrong token, and of the right one.
  for (const char* const token : {"geheim-0815", kToken}) {
    ExpectNone(serve::Ask(
        served.port(),
        absl::StrCat("POST /api/v1/alarms/", id,
                     "/acknowledgement HTTP/1.1\r\nHost: localhost\r\n"
                     "Authorization: Bearer ",
                     token,
                     "\r\nContent-Length: 14\r\n\r\n{\"who\": \"Ann\"}")));
  }
  EXPECT_THAT(served.Get("/alarms.html"), HasSubstr("by Ann at "));
  EXPECT_EQ(served.Stop(SIGTERM), 0);
  ExpectNone(Content(scratch_ / "log.txt"));
  EXPECT_THAT(FilesWithASecret(), ::testing::IsEmpty());
}

}  // namespace
}  // namespace mle
