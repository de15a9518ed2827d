// SQLite files, read as the same rows in a CSV file are.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/row_source.h"
#include "mle/data/tag_file.h"
#include "mle/database/database_name.h"
#include "mle/database/database_session.h"
#include "mle/database/record_sources.h"
#include "tests/mle/database/sqlite_file.h"
#include "tests/mle/database/tank_rows.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class SqliteTest : public ::testing::Test {
 protected:
  SqliteTest() {
    file_.Run(
        "CREATE TABLE trend (time TEXT, level REAL, level_setpoint REAL, "
        "steam REAL); INSERT INTO trend VALUES " +
        TankValues(TankRows()));
  }

  const SqliteFile file_;
};

TEST_F(SqliteTest, TableAndQueryGiveTheRecordsOfTheFile) {
  const auto of_file = ImportCsv(TankCsv(TankRows()));
  ExpectSame(of_file, ImportFrom(file_.name(), {.table = "trend"}));
  ExpectSame(of_file,
             ImportFrom(file_.name(),
                        {.query = "SELECT * FROM trend ORDER BY time;\n "}));
  ExpectSame(of_file,
             ImportFrom(file_.name(),
                        {.table = "trend",
                         .columns = {"Level", "steam", "level_setpoint"}}));
  // sqlite:///PATH, as others write it.
  ExpectSame(of_file,
             ImportFrom("sqlite://" + file_.path(), {.table = "main.trend"}));
}

// Rows that a source has, without the header.
int RowsOf(const std::string& name, const DatabaseOptions& database,
           const HistorianOptions& import) {
  const auto sources = RecordSources({name}, database, import);
  EXPECT_TRUE(sources.ok()) << sources.status();
  return static_cast<int>(AllRows(sources->front()).size()) - 1;
}

TEST_F(SqliteTest, RowsFarFromTheTimeRangeStayInTheDatabase) {
  file_.Run(
      "INSERT INTO trend VALUES ('2024-03-01T06:00', 1, 1, 1), "
      "('2024-03-20 06:00', 1, 1, 1)");
  HistorianOptions import;
  EXPECT_EQ(RowsOf(file_.name(), {.table = "trend"}, import), 602);
  // A day more than asked for, and two at the end: for zones, and for T.
  import.begin = "2024-03-10 03:00";
  EXPECT_EQ(RowsOf(file_.name(), {.table = "trend"}, import), 601);
  import.end = "2024-03-10 04:00";
  EXPECT_EQ(RowsOf(file_.name(), {.table = "trend"}, import), 600);
  const std::string query =
      "SELECT * FROM trend WHERE time BETWEEN '{begin}' AND '{end}'";
  EXPECT_EQ(RowsOf(file_.name(), {.query = query}, import), 600);
  EXPECT_EQ(RowsOf(file_.name(), {.query = query}, HistorianOptions()), 602);
  import.end = "2024-03-08 01:00";
  import.begin = "2024-03-08";
  EXPECT_THAT(ErrorFrom(file_.name(), {.table = "trend"}, import),
              HasSubstr("between begin and end"));
}

TEST_F(SqliteTest, ReportNamesTheTable) {
  const auto import = ImportFrom(file_.name(), {.table = "trend"});
  ASSERT_TRUE(import.ok()) << import.status();
  ASSERT_EQ(import->report.files.size(), 1u);
  EXPECT_EQ(import->report.files[0].name, file_.name() + ", table trend");
  EXPECT_EQ(import->report.files[0].rows, 600);
  EXPECT_EQ(import->report.channels[0].bad.empty, 6);
}

TEST_F(SqliteTest, RowsInAnyOrderOfTheTable) {
  file_.Run("CREATE TABLE mixed AS SELECT * FROM trend ORDER BY steam % 7");
  const auto of_file = ImportCsv(TankCsv(TankRows()));
  ExpectSame(of_file, ImportFrom(file_.name(), {.table = "mixed"}));
  ExpectSame(of_file,
             ImportFrom(file_.name(),
                        {.query = "SELECT * FROM trend ORDER BY time DESC"}));
}

// As `.import run.csv trend` of sqlite3 makes it.
TEST_F(SqliteTest, NumbersMayBeText) {
  file_.Run(
      "CREATE TABLE t (time TEXT, level TEXT, steam TEXT);"
      "WITH RECURSIVE k(k) AS (SELECT 0 UNION ALL SELECT k + 1 FROM k WHERE k "
      "< 199) INSERT INTO t SELECT k, k % 7, '1e0' FROM k");
  const auto import = ImportFrom(file_.name(), {.table = "t"});
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_EQ(import->records[0].samples(), 200);
  EXPECT_EQ(import->records[0].outputs(0, 199), 199 % 7);
}

// Text is in order of time only if the year stands first.
TEST_F(SqliteTest, DatesMayBeOfAnyForm) {
  file_.Run(
      "CREATE TABLE pi (Timestamp TEXT, level REAL, steam REAL);"
      "INSERT INTO pi VALUES ('31-Mar-24 23:58:00', 1, 1), "
      "('31-Mar-24 23:59:00', 2, 1), ('01-Apr-24 00:00:00', 3, 1), "
      "('01-Apr-24 00:01:00', 4, 1)");
  const auto import = ImportFrom(file_.name(), {.table = "pi"},
                                 {.columns = {.time_column = "Timestamp"}});
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_EQ(import->records[0].samples(), 4);
  EXPECT_EQ(import->records[0].outputs(0, 3), 4.0);
}

TEST_F(SqliteTest, LongTableAndQualities) {
  file_.Run(
      "CREATE TABLE archive (TagName TEXT, DateTime TEXT, Value REAL, "
      "Quality INTEGER);"
      "INSERT INTO archive SELECT 'level', time, level, 192 FROM trend "
      "WHERE level NOT NULL;"
      "INSERT INTO archive SELECT 'steam', time, steam, 192 FROM trend;"
      "INSERT INTO archive SELECT 'level_setpoint', time, level_setpoint, 192 "
      "FROM trend;"
      "UPDATE archive SET Quality = 0 WHERE TagName = 'level' AND "
      "DateTime = '2024-03-10 02:07:00'");
  std::vector<TankRow> rows = TankRows();
  rows[7].level = "";
  const HistorianOptions options = {.empty_fields = EmptyFields::kBad};
  ExpectSame(ImportCsv(TankCsv(rows), options),
             ImportFrom(file_.name(), {.table = "archive"}, options));
}

// Numbers keep their digits, and each value its own type.
TEST_F(SqliteTest, ValuesOfAnyType) {
  file_.Run(
      "CREATE TABLE t (time INTEGER, level, steam TEXT);"
      "INSERT INTO t VALUES (0, 0.1, '1'), (1, 1e-300, '2'), "
      "(2, 9007199254740993, '2.5'), (3, 'Bad', '3'), (4, NULL, '4'), "
      "(5, 0.30000000000000004, 5), (6, '7', '6')");
  const auto import =
      ImportFrom(file_.name(), {.query = "SELECT time, level, steam FROM t"});
  ExpectSame(import, ImportCsv("time,level,steam\n0,0.1,1\n1,1e-300,2\n"
                               "2,9007199254740993,2.5\n3,Bad,3\n4,,4\n"
                               "5,0.30000000000000004,5\n6,7,6\n"));
  ASSERT_TRUE(import.ok());
  EXPECT_EQ(import->report.channels[0].bad.declared, 1);
  EXPECT_EQ(import->report.channels[0].bad.empty, 1);
  EXPECT_EQ(import->records[0].outputs(0, 5), 0.30000000000000004);
}

TEST_F(SqliteTest, TimeRangeIsThatOfTheFile) {
  const HistorianOptions options = {.begin = "2024-03-10 03:00",
                                    .end = "2024-03-10 08:30:30"};
  const auto of_file = ImportCsv(TankCsv(TankRows()), options);
  ExpectSame(of_file, ImportFrom(file_.name(), {.table = "trend"}, options));
  ASSERT_TRUE(of_file.ok()) << of_file.status();
  EXPECT_EQ(of_file->report.rows, 331);
  EXPECT_THAT(
      ErrorFrom(file_.name(), {.table = "trend"}, {.begin = "2025-01-01"}),
      HasSubstr("the table has no rows between begin and end"));
}

TEST_F(SqliteTest, IsOnlyRead) {
  const std::string before = Bytes(file_.path());
  for (const char* const query :
       {"DELETE FROM trend RETURNING *", "DROP TABLE trend",
        "INSERT INTO trend VALUES (1, 2, 3, 4) RETURNING *",
        "UPDATE trend SET level = 0 RETURNING *"}) {
    EXPECT_THAT(ErrorFrom(file_.name(), {.query = query}),
                HasSubstr("readonly"))
        << query;
  }
  EXPECT_EQ(Bytes(file_.path()), before);

  const std::string missing = file_.folder() + "/none.db";
  EXPECT_THAT(ErrorFrom("sqlite:" + missing, {.table = "trend"}),
              AllOf(HasSubstr("sqlite:" + missing + ", table trend"),
                    HasSubstr("unable to open database file")));
  EXPECT_FALSE(std::filesystem::exists(missing));
}

TEST_F(SqliteTest, WhatFollowsAQueryIsRefused) {
  for (const char* const query :
       {"SELECT * FROM trend; SELECT 1", "SELECT * FROM trend; x",
        "SELECT * FROM trend; -- and\n DELETE FROM trend"}) {
    EXPECT_THAT(ErrorFrom(file_.name(), {.query = query}),
                HasSubstr("a query is one statement"))
        << query;
  }
  HistorianOptions options;
  options.columns.ignore_other_columns = true;
  ExpectSame(
      ImportFrom(file_.name(), {.table = "trend"}),
      ImportFrom(file_.name(),
                 {.query = "SELECT *, ';' AS x FROM trend; -- all; of it"},
                 options));
}

TEST_F(SqliteTest, LongValuesAreRefused) {
  for (const char* const value :
       {"zeroblob(900000000)", "CAST(zeroblob(2000000) AS TEXT)"}) {
    EXPECT_THAT(ErrorFrom(file_.name(),
                          {.query = absl::StrCat("SELECT time, level, ", value,
                                                 " AS steam FROM trend")}),
                HasSubstr("too big"))
        << value;
  }
}

// Without an end, and without a row.
TEST_F(SqliteTest, QueriesWithoutAnEndAreEnded) {
  const auto error = [&](const SqlLimits& limits, const std::string& where) {
    const absl::StatusOr<DatabaseName> name = ParseDatabaseName(file_.name());
    EXPECT_TRUE(name.ok());
    auto session = DatabaseSession::Connect(*name, limits, {});
    EXPECT_TRUE(session.ok()) << session.status();
    absl::Status status =
        (*session)
            ->Start(
                "WITH RECURSIVE k(k) AS (SELECT 0 UNION ALL SELECT k + 1 "
                "FROM k) SELECT k FROM k" +
                where)
            .status();
    RowBlock rows;
    while (status.ok()) {
      rows.Clear();
      status = (*session)->Read(100, rows).status();
    }
    return std::string(status.message());
  };
  EXPECT_THAT(error({.max_rows = 1000}, ""), HasSubstr("more than 1000 rows"));
  EXPECT_THAT(error({.max_wait_s = 0}, " WHERE k < 0"),
              HasSubstr("no rows came for 0 s"));
}

TEST_F(SqliteTest, MissingTableAndColumns) {
  EXPECT_THAT(ErrorFrom(file_.name(), {.table = "trends"}),
              AllOf(HasSubstr("table = trends is not in the database"),
                    HasSubstr("(nearest: 'trend')")));
  EXPECT_THAT(
      ErrorFrom(file_.name(), {.table = "trend", .columns = {"levl", "x"}}),
      AllOf(HasSubstr("no column 'levl' (nearest: 'level'), 'x'"),
            HasSubstr("'steam'")));
  EXPECT_THAT(ErrorFrom(file_.name(), {.query = "SELECT time, lev FROM trend"}),
              HasSubstr("no such column: lev"));
  EXPECT_THAT(ErrorFrom(file_.name(), {.query = "SELECT time FROM trend"}),
              AllOf(HasSubstr(", query: header"),
                    HasSubstr("there is no column 'level'")));
}

TEST_F(SqliteTest, NothingToReadIsSaid) {
  EXPECT_THAT(
      ErrorFrom(file_.name(), {.query = "SELECT * FROM trend WHERE steam < 0"}),
      HasSubstr("the query returns no rows"));
  file_.Run("CREATE TABLE empty (time, level, steam)");
  EXPECT_THAT(ErrorFrom(file_.name(), {.table = "empty"}),
              HasSubstr("the table has no rows"));
}

TEST_F(SqliteTest, MessagesNameRowsAndColumns) {
  file_.Run("UPDATE trend SET level = 'Stoerung' WHERE steam = 0.5");
  EXPECT_THAT(ErrorFrom(file_.name(), {.table = "trend"}),
              AllOf(HasSubstr(", table trend: row 6, column 2 ('level')"),
                    HasSubstr("'Stoerung' (1)"), Not(HasSubstr("line"))));
  EXPECT_THAT(
      ErrorFrom(file_.name(),
                {.query = "SELECT * FROM trend UNION ALL SELECT * FROM trend"},
                {.any_word_is_bad = true}),
      HasSubstr("row 601, column 1 ('time'): time"));
}

// Names are quoted as SQL has it, and can be nothing else.
TEST_F(SqliteTest, NamesCannotBecomeCommands) {
  for (const char* const table :
       {"trend\"; DROP TABLE trend; --", "trend; DROP TABLE trend",
        "(SELECT * FROM trend)", "trend WHERE 1 = 1", "trend--", "\"trend", "",
        ".", "trend.", "\"a\"b"}) {
    EXPECT_FALSE(ImportFrom(file_.name(), {.table = table}).ok()) << table;
  }
  EXPECT_EQ(file_.Value("SELECT count(*) FROM trend"), "600");

  const std::string odd = "a \"b\"; DROP TABLE trend; --.x";
  const std::string quoted =
      "\"" + absl::StrReplaceAll(odd, {{"\"", "\"\""}}) + "\"";
  file_.Run("CREATE TABLE " + quoted +
            " (time, \"level\"\"'; --\", \"s\nt\te,am\");"
            "INSERT INTO " +
            quoted + " SELECT time, level, steam FROM trend");
  HistorianOptions options;
  options.columns.tags = {{"level\"'; --", "level"}, {"s t e,am", "steam"}};
  ExpectSame(
      ImportFrom(file_.name(),
                 {.query = "SELECT time, level, steam FROM trend"}),
      ImportFrom(file_.name(),
                 {.table = quoted, .columns = {"level\"'; --", "s\nt\te,am"}},
                 options));
}

TEST_F(SqliteTest, TextCannotLeaveItsField) {
  file_.Run(
      "CREATE TABLE t (time, level, steam, note);"
      "INSERT INTO t VALUES (0, 1, 2, 'a,b\"c\n0,5,6,x\n'), "
      "(1, 2, 3, CAST(x'41000a22' AS TEXT)), (2, 3, 4, x'ff00fe'), "
      "(3, 4, 5, '\r\n')");
  HistorianOptions options;
  options.columns.ignore_other_columns = true;
  ExpectSame(ImportCsv("time,level,steam\n0,1,2\n1,2,3\n2,3,4\n3,4,5\n"),
             ImportFrom(file_.name(), {.table = "t"}, options));
  file_.Run("UPDATE t SET level = CAST(x'3100' AS TEXT) WHERE time = 2");
  EXPECT_THAT(ErrorFrom(file_.name(), {.table = "t"}, options),
              HasSubstr("row 3, column 2 ('level'): '1\\x00' is not"));
}

TEST_F(SqliteTest, HeaderIsNotTakenForAnotherKindOfFile) {
  for (const char* const name : {"PAR1", "BZh", "%PDF", "sep=;"}) {
    HistorianOptions options;
    options.columns.ignore_other_columns = true;
    ExpectSame(
        ImportCsv(TankCsv(TankRows())),
        ImportFrom(file_.name(),
                   {.query = absl::StrCat("SELECT 1 AS \"", name,
                                          "\", * FROM trend ORDER BY time")},
                   options));
  }
}

TEST_F(SqliteTest, OtherFilesAreRefused) {
  const std::string path = file_.folder() + "/text.db";
  std::ofstream(path) << std::string(5000, 'x');
  EXPECT_THAT(ErrorFrom("sqlite:" + path, {.table = "trend"}),
              HasSubstr("not a database"));
  // And a database that is named as a file is told apart.
  EXPECT_THAT(
      std::string(
          ImportHistorian({file_.path()}, Tank(), {}).status().message()),
      HasSubstr("name it sqlite:FILE"));
}

TEST_F(SqliteTest, AllReadsSeeTheSameRows) {
  const auto sources = RecordSources({file_.name()}, {.table = "trend"}, {});
  ASSERT_TRUE(sources.ok()) << sources.status();
  const auto read = [&] { return AllRows((*sources)[0]); };
  const auto first = read();
  EXPECT_EQ(first.size(), 601u);
  EXPECT_EQ(read(), first);
}

TEST_F(SqliteTest, TagsAreProposed) {
  const auto sources = RecordSources({file_.name()}, {.table = "trend"}, {});
  ASSERT_TRUE(sources.ok()) << sources.status();
  const auto proposals = ProposeTags(*sources, Tank(), {});
  ASSERT_TRUE(proposals.ok()) << proposals.status();
  ASSERT_EQ(proposals->size(), 3u);
  EXPECT_EQ((*proposals)[2].channel, "steam");
}

}  // namespace
}  // namespace mle
