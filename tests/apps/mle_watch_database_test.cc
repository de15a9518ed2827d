// mle_watch with records in databases: what it finds is what it finds in files
// with the same rows, and only what is new is read.

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/watch_site.h"
#include "tests/mle/database/postgresql_server.h"
#include "tests/mle/database/sqlite_file.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class WatchDatabaseTest : public WatchSite {
 protected:
  // `source`: the keys that say where the records are.
  void List(const std::string& source) const {
    scratch_.Write("controllers.json", absl::StrCat(R"({"version": 1,
        "controllers": [{"name": "tank", "model": "tank.json",
        "reference_days": 8, )",
                                                    source, "}]}"));
  }
  // What files with all days lead to.
  nlohmann::json OfFiles() const {
    WriteDays(0, 40);
    EXPECT_EQ(Watch("files").exit_code, 0);
    return Found("files");
  }
  nlohmann::json Found(const std::string& out) const {
    nlohmann::json tank = Tank(out);
    for (const char* const key : {"page", "proposals"}) tank.erase(key);
    return tank;
  }
};

TEST_F(WatchDatabaseTest, TableOfSqliteGivesWhatFilesGive) {
  const nlohmann::json of_files = OfFiles();
  const SqliteFile file;
  file.Run("CREATE TABLE trend (time TEXT, level REAL, steam REAL)");
  List(
      absl::StrCat("\"records\": \"", file.name(), "\", \"table\": \"trend\""));
  int from = 0;
  for (const int until : {5, 9, 26, 40}) {
    file.Run(days_.Insert("trend", from, until));
    from = until;
    EXPECT_EQ(Watch("table").exit_code, 0);
  }
  EXPECT_EQ(Found("table"), of_files);
  const std::string state = Content(scratch_ / "table/watch.json");
  EXPECT_EQ(Watch("table").exit_code, 0);
  EXPECT_EQ(Content(scratch_ / "table/watch.json"), state);
}

TEST_F(WatchDatabaseTest, OnlyWhatIsNewIsRead) {
  const SqliteFile file;
  file.Run("CREATE TABLE trend (time TEXT, level REAL, steam REAL)");
  file.Run(days_.Insert("trend", 0, 20));
  List(absl::StrCat("\"records\": \"", file.name(), "\", \"query\": ",
                    "\"SELECT * FROM trend WHERE time >= '{begin}' ORDER BY "
                    "time\""));
  EXPECT_EQ(Watch().exit_code, 0);
  // Two days of overlap, what acts on these, and a day for zones are read.
  file.Run(
      "UPDATE trend SET level = 1000, steam = 1000 WHERE time < "
      "'2026-01-15'");
  file.Run(days_.Insert("trend", 20, 25));
  EXPECT_EQ(Watch().exit_code, 0);
  EXPECT_EQ(Tank()["status"], "healthy");
  EXPECT_EQ(Tank()["last_day"], "2026-01-25");
  EXPECT_GT(Tank()["health"], 0.9);
}

TEST_F(WatchDatabaseTest, LateCorrectedAndRepeatedRowsOfTheOverlapAreTakenIn) {
  const nlohmann::json of_files = OfFiles();
  const SqliteFile file;
  file.Run("CREATE TABLE trend (time TEXT, level REAL, steam REAL)");
  List(absl::StrCat("\"records\": \"", file.name(),
                    "\", \"table\": \"trend\", \"overlap_days\": 3"));
  file.Run(days_.Insert("trend", 0, 18));
  file.Run(days_.Insert("trend", 18, 19, 5.0));  // wrong, and corrected later
  file.Run(days_.Insert("trend", 20, 21));       // day 19 comes late
  EXPECT_EQ(Watch("late").exit_code, 0);
  file.Run("DELETE FROM trend WHERE time LIKE '2026-01-19%'");
  file.Run(days_.Insert("trend", 18, 20));
  file.Run(days_.Insert("trend", 20, 21));  // once more
  file.Run(days_.Insert("trend", 21, 40));
  EXPECT_EQ(Watch("late").exit_code, 0);
  EXPECT_EQ(Found("late"), of_files);
}

TEST_F(WatchDatabaseTest, AServerThatIsGoneIsCaughtUpWhenItIsBack) {
  if (!PostgresqlServer::IsInstalled()) GTEST_SKIP() << "no PostgreSQL";
  const nlohmann::json of_files = OfFiles();
  const PostgresqlServer server;
  ASSERT_TRUE(server.is_running());
  server.Run("CREATE TABLE trend (time TIMESTAMP, level FLOAT8, steam FLOAT8)");
  server.Run(days_.Insert("trend", 0, 20));
  const std::string there = absl::StrCat("\"records\": \"", server.name(),
                                         "\", \"table\": \"trend\"");
  List(there);
  EXPECT_EQ(Watch("server").exit_code, 0);
  List(
      "\"records\": \"postgresql://nobody@127.0.0.1:1/plant\", "
      "\"table\": \"trend\"");
  const report::ProcessResult run = Watch("server");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("tank: records: "));
  EXPECT_EQ(Tank("server")["status"], "failed");
  server.Run(days_.Insert("trend", 20, 40));
  List(there);
  EXPECT_EQ(Watch("server").exit_code, 0);
  EXPECT_EQ(Found("server"), of_files);
}

TEST_F(WatchDatabaseTest, AStateInPostgresqlSaysWhatAFileSays) {
  if (!PostgresqlServer::IsInstalled()) GTEST_SKIP() << "no PostgreSQL";
  const nlohmann::json of_files = OfFiles();
  const PostgresqlServer server;
  ASSERT_TRUE(server.is_running());
  std::vector<std::string> arguments = Arguments("server");
  arguments.push_back("--state=" + server.name("postgres"));
  EXPECT_EQ(RunTested(arguments).exit_code, 0);
  EXPECT_EQ(Found("server"), of_files);
  const int alarms = AlarmsHandedOn();
  EXPECT_EQ(RunTested(arguments).exit_code, 0);
  EXPECT_EQ(Found("server"), of_files);
  EXPECT_EQ(AlarmsHandedOn(), alarms);
  EXPECT_EQ(server.Value("SELECT COUNT(*) FROM mle_watch.alarm"),
            std::to_string(of_files["alarms"].size()));
}

TEST_F(WatchDatabaseTest, PartsShareAStateAndOneRunShowsAll) {
  if (!PostgresqlServer::IsInstalled()) GTEST_SKIP() << "no PostgreSQL";
  const PostgresqlServer server;
  ASSERT_TRUE(server.is_running());
  WriteDays(0, 40);
  std::string list = R"({"version": 1, "controllers": [)";
  constexpr int kControllers = 5;
  for (int c = 0; c < kControllers; ++c) {
    absl::StrAppend(&list, c == 0 ? "" : ", ", R"({"name": "tank)", c,
                    R"(", "model": "tank.json", "records": ")",
                    c == 2 ? "nowhere" : "records",
                    R"(", "reference_days": 8})");
  }
  scratch_.Write("controllers.json", list + "]}");
  const auto run = [&](const std::string& out, const std::string& flag) {
    std::vector<std::string> arguments = Arguments(out);
    arguments.push_back("--state=" + server.name("postgres"));
    arguments.push_back(flag);
    return RunTested(arguments);
  };
  int looked_at = 0;
  int failed = 0;
  for (const char* const part : {"1", "2", "3"}) {
    failed += run("site", absl::StrCat("--part=", part, "/3")).exit_code;
    looked_at += static_cast<int>(
        ParsedJson(scratch_ / absl::StrCat("site/parts/", part,
                                           "-of-3/watch.json"))["controllers"]
            .size());
  }
  EXPECT_EQ(looked_at, kControllers);
  EXPECT_EQ(failed, 1);  // the part with the broken one
  EXPECT_EQ(AlarmsHandedOn(), 0);
  run("site", "--noupdate");
  const nlohmann::json site =
      ParsedJson(scratch_ / "site/watch.json")["controllers"];
  int aged = 0;
  int alarms = 0;
  for (const nlohmann::json& controller : site) {
    aged += controller["status"] == "aged" ? 1 : 0;
    alarms += static_cast<int>(controller["alarms"].size());
  }
  EXPECT_EQ(aged, kControllers - 1);
  EXPECT_EQ(AlarmsHandedOn(), alarms);
}

TEST_F(WatchDatabaseTest, MistakesOfTheListAreNamed) {
  WriteDays(0, 1);
  const auto error = [this](const std::string& source) {
    List(source);
    const report::ProcessResult run = Watch();
    EXPECT_EQ(run.exit_code, 2);
    return run.err;
  };
  EXPECT_THAT(error(R"("records": "sqlite:a.db")"),
              HasSubstr("either table or query"));
  EXPECT_THAT(error(R"("records": "sqlite:a.db", "query": "SELECT 1")"),
              HasSubstr("{begin}"));
  EXPECT_THAT(error(R"("records": "records", "table": "trend")"),
              HasSubstr("are for databases"));
  EXPECT_THAT(error(R"("records": "records", "overlap_days": 3)"),
              HasSubstr("overlap_days"));
  const std::string password =
      error(R"("records": "postgresql://a:geheim@h/n", "table": "t")");
  EXPECT_THAT(password, HasSubstr("PGPASSWORD"));
  EXPECT_THAT(password, Not(HasSubstr("geheim")));
}

}  // namespace
}  // namespace mle
