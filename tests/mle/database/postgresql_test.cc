// A real PostgreSQL server, read as the same rows in a CSV file are.

#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/row_source.h"
#include "mle/database/record_sources.h"
#include "tests/mle/database/postgresql_server.h"
#include "tests/mle/database/tank_rows.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class PostgresqlTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!PostgresqlServer::IsInstalled()) {
      GTEST_SKIP() << "Debian's package postgresql is not installed";
    }
    server_.emplace();
    ASSERT_TRUE(server_->is_running());
    server_->Run(
        "CREATE TABLE trend (time timestamptz, level double precision, "
        "level_setpoint real, steam numeric);"
        "INSERT INTO trend VALUES " +
        TankValues(TankRows(), "+00") + ";");
  }

  std::string name() const { return server_->name(); }

  std::optional<PostgresqlServer> server_;
};

TEST_F(PostgresqlTest, TablesViewsAndQueriesGiveTheRecordsOfTheFile) {
  const auto of_file = ImportCsv(TankCsv(TankRows()));
  ExpectSame(of_file, ImportFrom(name(), {.table = "trend"}));
  ExpectSame(
      of_file,
      ImportFrom(name(), {.table = "public.trend",
                          .columns = {"level", "steam", "level_setpoint"}}));
  ExpectSame(
      of_file,
      ImportFrom(name(), {.query = "WITH t AS (SELECT * FROM trend) SELECT "
                                   "time::timestamptz, level, level_setpoint, "
                                   "steam FROM t ORDER BY 1;"}));

  // Views: in UTC without a zone, in local time with and without clock changes.
  server_->Run(
      "CREATE VIEW utc AS SELECT time AT TIME ZONE 'UTC' AS time, level, "
      "level_setpoint, steam FROM trend;"
      "CREATE VIEW local AS SELECT time AT TIME ZONE 'America/New_York' AS "
      "time, level, level_setpoint, steam FROM trend;");
  ExpectSame(of_file, ImportFrom(name(), {.table = "utc"}));
  HistorianOptions local;
  local.clock.time_zone = "America/New_York";
  const auto of_view = ImportFrom(name(), {.table = "local"}, local);
  ExpectSame(of_file, of_view);
  ASSERT_TRUE(of_view.ok());
  EXPECT_EQ(of_view->report.Times("min").At(0.0), "2024-03-09 21:00");

  // Without the zone the hour that was left out is a gap.
  const auto of_gap = ImportFrom(name(), {.table = "local"});
  ASSERT_TRUE(of_gap.ok()) << of_gap.status();
  EXPECT_EQ(of_gap->report.num_gaps, 1);

  // The same range for all of them, of which the server is told a wider one.
  HistorianOptions range = {.begin = "2024-03-10 03:00",
                            .end = "2024-03-10 08:30"};
  const auto cut = ImportCsv(TankCsv(TankRows()), range);
  ExpectSame(cut, ImportFrom(name(), {.table = "trend"}, range));
  ExpectSame(cut, ImportFrom(name(), {.table = "utc"}, range));
  range.clock.time_zone = "America/New_York";
  range.begin = "2024-03-09 22:00";
  range.end = "2024-03-10 04:30";
  ExpectSame(cut, ImportFrom(name(), {.table = "local"}, range));
  range.begin = "2025-01-01";
  range.end = "";
  EXPECT_THAT(ErrorFrom(name(), {.table = "local"}, range),
              HasSubstr("the table has no rows between begin and end"));
}

TEST_F(PostgresqlTest, LongTables) {
  server_->Run(
      "CREATE TABLE archive (tag text, time timestamptz, value double "
      "precision, quality text);"
      "INSERT INTO archive SELECT 'level', time, level, 'good' FROM trend "
      "WHERE level IS NOT NULL;"
      "INSERT INTO archive SELECT 'level_setpoint', time, level_setpoint, "
      "'good' FROM trend;"
      "INSERT INTO archive SELECT 'STEAM', time, steam, 'good' FROM trend;"
      "INSERT INTO archive SELECT 'other', time, 0, 'good' FROM trend;");
  HistorianOptions options = {.empty_fields = EmptyFields::kBad};
  options.columns.ignore_other_columns = true;
  ExpectSame(ImportCsv(TankCsv(TankRows()), options),
             ImportFrom(name(), {.table = "archive"}, options));
  EXPECT_THAT(
      ErrorFrom(name(),
                {.query = "SELECT * FROM archive UNION ALL (SELECT * FROM "
                          "archive LIMIT 1)"}),
      HasSubstr(", query: row "));
}

TEST_F(PostgresqlTest, LongValuesAreRefused) {
  EXPECT_THAT(
      ErrorFrom(name(), {.query = "SELECT time, level, repeat('1', 2000000) "
                                  "AS steam FROM trend"}),
      HasSubstr("a value is too big: 2000000 bytes"));
}

TEST_F(PostgresqlTest, TimesHaveTheirFractions) {
  server_->Run(
      "CREATE TABLE fast AS SELECT timestamptz '2024-03-10 06:00:00.5+02' + k "
      "* interval '0.25 s' AS time, k AS level, 1 AS steam FROM "
      "generate_series(0, 99) k;");
  const auto import = ImportFrom(name(), {.table = "fast"});
  ASSERT_TRUE(import.ok()) << import.status();
  // A step has seven digits.
  EXPECT_NEAR(import->report.sample_time * 60.0, 0.25, 1e-6);
  EXPECT_EQ(*import->report.time_origin, 1710043200.5);
  EXPECT_EQ(import->report.rows, 100);
}

TEST_F(PostgresqlTest, PasswordsComeFromElsewhere) {
  const DatabaseOptions trend = {.table = "trend"};
  const std::string reader = server_->name("reader");
  const std::string password = PostgresqlServer::kPassword;
  const auto of_file = ImportCsv(TankCsv(TankRows()));
  ::unsetenv("PGPASSWORD");
  ::setenv("PGPASSFILE", "/nonexistent", 1);
  EXPECT_THAT(ErrorFrom(reader, trend), AllOf(HasSubstr("no password supplied"),
                                              HasSubstr("set PGPASSWORD")));

  ::setenv("PGPASSWORD", "falsch-0815", 1);
  EXPECT_THAT(ErrorFrom(reader, trend),
              AllOf(HasSubstr("password authentication failed"),
                    Not(HasSubstr("falsch-0815"))));
  ::setenv("PGPASSWORD", password.c_str(), 1);
  ExpectSame(of_file, ImportFrom(reader, trend));
  ::unsetenv("PGPASSWORD");

  // Asked for, once a session.
  int asked = 0;
  DatabaseOptions asking = trend;
  std::string answer = password;
  asking.ask_password = [&](const std::string& prompt) {
    EXPECT_THAT(prompt, HasSubstr(reader));
    ++asked;
    return std::optional<std::string>(answer);
  };
  ExpectSame(of_file, ImportFrom(reader, asking));
  EXPECT_EQ(asked, 1);
  answer = "falsch' \"0815=\\";
  EXPECT_THAT(ErrorFrom(reader, asking),
              AllOf(HasSubstr("password authentication failed"),
                    Not(HasSubstr("0815"))));
  server_->Run("ALTER ROLE reader PASSWORD 'falsch'' \"0815=\\'");
  ExpectSame(of_file, ImportFrom(reader, asking));
  server_->Run(absl::StrCat("ALTER ROLE reader PASSWORD '", password, "'"));

  // A file of passwords, and one of services.
  const std::string files = server_->folder() + "/passwords";
  std::ofstream(files) << "*:*:plant:reader:" << password << "\n";
  ::chmod(files.c_str(), 0600);
  ::setenv("PGPASSFILE", files.c_str(), 1);
  ExpectSame(of_file, ImportFrom(reader, trend));
  ::unsetenv("PGPASSFILE");
  const std::string services = server_->folder() + "/services";
  std::ofstream(services) << "[tank]\nhost=" << server_->folder()
                          << "\ndbname=plant\nuser=reader\npassword="
                          << password << "\n";
  ::setenv("PGSERVICEFILE", services.c_str(), 1);
  ExpectSame(of_file, ImportFrom("postgresql:///?service=tank", trend));
  ::unsetenv("PGSERVICEFILE");
}

TEST_F(PostgresqlTest, MistakesAreNamed) {
  EXPECT_THAT(ErrorFrom(name(), {.table = "Trend"}),
              AllOf(HasSubstr("table = Trend is not in the database"),
                    HasSubstr("(nearest: 'trend')")));
  EXPECT_THAT(ErrorFrom(name(), {.table = "trend", .columns = {"lvel"}}),
              HasSubstr("no column 'lvel' (nearest: 'level')"));
  EXPECT_THAT(ErrorFrom(name(), {.query = "SELECT time, lvel FROM trend"}),
              AllOf(HasSubstr(", query: ERROR:  column \"lvel\" does not "
                              "exist"),
                    Not(HasSubstr("\n"))));
  EXPECT_THAT(ErrorFrom(name(), {.query = "SELECT * FROM trend WHERE false"}),
              HasSubstr("the query returns no rows"));
  EXPECT_THAT(ErrorFrom(name(), {.query = "SELEC 1"}),
              HasSubstr("syntax error"));
  EXPECT_THAT(
      ErrorFrom(name(), {.query = "SELECT time, 'Stoerung' AS level, 1 AS "
                                  "steam FROM trend ORDER BY time"}),
      HasSubstr(", query: row 1, column 2 ('level'): 'Stoerung' is not"));
  EXPECT_THAT(ErrorFrom("postgresql://open@/nowhere?host=" + server_->folder(),
                        {.table = "trend"}),
              HasSubstr("database \"nowhere\" does not exist"));
  EXPECT_EQ(ImportFrom("postgresql://open@/plant?host=/nonexistent",
                       {.table = "trend"})
                .status()
                .code(),
            absl::StatusCode::kUnavailable);
  server_->Run("CREATE ROLE stranger LOGIN");
  EXPECT_THAT(ErrorFrom(server_->name("stranger"), {.table = "trend"}),
              HasSubstr("permission denied"));
}

TEST_F(PostgresqlTest, IsOnlyRead) {
  // Of somebody who may do everything.
  const std::string owner = server_->name("postgres");
  server_->Run(
      "CREATE FUNCTION sly() RETURNS integer LANGUAGE sql AS "
      "'DELETE FROM trend RETURNING 1'");
  for (const char* const query :
       {"DELETE FROM trend", "DELETE FROM trend RETURNING *",
        "SELECT 1; DROP TABLE trend",
        "SELECT 1 AS time; COMMIT; DROP TABLE trend",
        "WITH d AS (DELETE FROM trend RETURNING *) SELECT * FROM d",
        "SELECT sly() AS time", "SELECT * INTO other FROM trend"}) {
    EXPECT_FALSE(ImportFrom(owner, {.query = query}).ok()) << query;
  }
  for (const char* const table :
       {"trend\"; DROP TABLE trend; --", "trend; DROP TABLE trend; --"}) {
    EXPECT_FALSE(ImportFrom(owner, {.table = table}).ok()) << table;
  }
  EXPECT_EQ(server_->Value("SELECT count(*) FROM trend"), "600");
}

TEST_F(PostgresqlTest, AllReadsSeeTheSameRows) {
  const auto sources = RecordSources({name()}, {.table = "trend"}, {});
  ASSERT_TRUE(sources.ok()) << sources.status();
  const auto read = [&] { return AllRows((*sources)[0]); };
  const auto first = read();
  EXPECT_EQ(first.size(), 601u);
  server_->Run(
      "INSERT INTO trend SELECT time + interval '1 day', 1, 1, 1 FROM "
      "trend; DELETE FROM trend WHERE steam < 5;");
  EXPECT_EQ(read(), first);
  EXPECT_NE(ImportFrom(name(), {.table = "trend"})->report.rows, 600);
}

// A server that goes away in the middle leaves nothing half-read.
TEST_F(PostgresqlTest, ServerThatGoesAwayIsSaid) {
  server_->Run(
      "CREATE TABLE big AS SELECT timestamptz '2024-01-01' + k * interval "
      "'1 min' AS time, k AS level, 1 AS steam FROM generate_series(1, 50000) "
      "k;");
  const auto sources = RecordSources({name()}, {.table = "big"}, {});
  ASSERT_TRUE(sources.ok()) << sources.status();
  auto rows = (*sources)[0].open_rows();
  ASSERT_TRUE(rows.ok()) << rows.status();
  std::vector<std::string_view> fields;
  EXPECT_TRUE((*rows)->Next(fields));
  server_->Kill();
  while ((*rows)->Next(fields)) {
  }
  const absl::Status& fault = (*rows)->status();
  EXPECT_EQ(fault.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(
      std::string(fault.message()),
      AllOf(HasSubstr(", table big: reading failed after row "),
            HasSubstr("server closed the connection"), Not(HasSubstr("\n"))));
}

TEST_F(PostgresqlTest, ImportFromAServerThatGoesAwayFails) {
  server_->Run(
      "CREATE TABLE big AS SELECT timestamptz '2024-01-01' + k * interval "
      "'1 min' AS time, k AS level, 1 AS steam FROM generate_series(1, 50000) "
      "k;");
  auto sources = RecordSources({name()}, {.table = "big"}, {});
  ASSERT_TRUE(sources.ok()) << sources.status();
  // The first opening looks at the form, the second one reads.
  int opened = 0;
  HistorianSource source = (*sources)[0];
  source.open_rows = [&, open = source.open_rows]() {
    auto rows = open();
    if (++opened == 2) server_->Kill();
    return rows;
  };
  const auto import = ImportHistorianSources({source}, Tank(), {});
  EXPECT_EQ(import.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(opened, 2);
  EXPECT_THAT(std::string(import.status().message()),
              HasSubstr("reading failed after row 4096"));
}

}  // namespace
}  // namespace mle
