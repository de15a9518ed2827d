// ODBC by two of its drivers, with data sources of its own.

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/database/record_sources.h"
#include "tests/mle/database/postgresql_server.h"
#include "tests/mle/database/sqlite_file.h"
#include "tests/mle/database/tank_rows.h"

// What unixODBC keeps of its files until the end of the process is not ours.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libodbcinst";
}

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Of Debian's packages, in the folder of the machine's kind.
std::string Driver(const std::string& file) {
  std::error_code error;
  for (const auto& folder :
       std::filesystem::directory_iterator("/usr/lib", error)) {
    const std::string path = folder.path().string() + "/odbc/" + file;
    if (std::filesystem::exists(path, error)) return path;
  }
  return "";
}

// Data sources by their files alone.
void UseSources(const std::string& folder, const std::string& text) {
  std::ofstream(folder + "/odbc.ini") << text;
  std::ofstream(folder + "/odbcinst.ini") << "";
  ::setenv("ODBCINI", (folder + "/odbc.ini").c_str(), 1);
  ::setenv("ODBCSYSINI", folder.c_str(), 1);
}

TEST(OdbcTest, SqliteGivesTheRecordsOfTheFile) {
  const std::string driver = Driver("libsqlite3odbc.so");
  if (driver.empty()) {
    GTEST_SKIP() << "Debian's package libsqliteodbc is not installed";
  }
  // It stays loaded, so that what it keeps can be told from ours.
  ::dlopen("libodbcinst.so.2", RTLD_LAZY | RTLD_NODELETE);
  // The driver writes numbers with 15 digits.
  constexpr int kDigits = 12;
  const SqliteFile file;
  file.Run(
      "CREATE TABLE trend (time VARCHAR(30), level DOUBLE, level_setpoint "
      "INTEGER, steam DOUBLE); INSERT INTO trend VALUES " +
      TankValues(TankRows(kDigits)));
  UseSources(file.folder(), absl::StrCat("[tank_file]\nDriver=", driver,
                                         "\nDatabase=", file.path(), "\n"));
  const auto of_file = ImportCsv(TankCsv(TankRows(kDigits)));
  ExpectSame(of_file, ImportFrom("odbc:tank_file", {.table = "trend"}));
  ExpectSame(of_file, ImportFrom("odbc:tank_file",
                                 {.query = "SELECT * FROM trend ORDER BY "
                                           "time;"}));
  ExpectSame(of_file, ImportFrom(absl::StrCat("odbc:Driver=", driver,
                                              ";Database=", file.path()),
                                 {.table = "trend"}));
  EXPECT_THAT(
      ErrorFrom("odbc:tank_file", {.query = "SELECT time, x FROM trend"}),
      HasSubstr("no such column: x"));
  EXPECT_THAT(
      ErrorFrom("odbc:other", {.table = "trend"}),
      AllOf(HasSubstr("odbc:other, table trend: "), HasSubstr("IM002")));
  EXPECT_THAT(
      ErrorFrom("odbc:tank_file", {.query = "SELECT time::text FROM trend"}),
      HasSubstr("CAST(x AS type)"));
  EXPECT_FALSE(
      ImportFrom("odbc:tank_file", {.table = "trend\"; DROP TABLE trend; --"})
          .ok());
  ImportFrom("odbc:tank_file", {.query = "DELETE FROM trend"}).IgnoreError();
  EXPECT_EQ(file.Value("SELECT count(*) FROM trend"), "600");
}

TEST(OdbcTest, PostgresqlGivesTheRecordsOfTheFile) {
  const std::string driver = Driver("psqlodbca.so");
  if (driver.empty() || !PostgresqlServer::IsInstalled()) {
    GTEST_SKIP() << "Debian's packages postgresql and odbc-postgresql are not "
                    "installed";
  }
  PostgresqlServer server;
  ASSERT_TRUE(server.is_running());
  server.Run(
      "CREATE TABLE trend (time timestamptz, level double precision, "
      "level_setpoint real, steam numeric, note text);"
      "INSERT INTO trend (time, level, level_setpoint, steam) VALUES " +
      TankValues(TankRows(), "+00") + ";");
  UseSources(server.folder(),
             absl::StrCat("[tank_server]\nDriver=", driver,
                          "\nServername=", server.folder(),
                          "\nDatabase=plant\nUseDeclareFetch=1\n"));
  ::setenv("MLE_ODBC_USER", "reader", 1);
  ::setenv("MLE_ODBC_PASSWORD", PostgresqlServer::kPassword, 1);
  HistorianOptions options;
  options.columns.ignore_other_columns = true;
  const auto of_file = ImportCsv(TankCsv(TankRows()));
  ExpectSame(of_file,
             ImportFrom("odbc:tank_server", {.table = "trend"}, options));
  HistorianOptions range = options;
  range.begin = "2024-03-10 03:00";
  range.end = "2024-03-10 08:30";
  ExpectSame(ImportCsv(TankCsv(TankRows()), range),
             ImportFrom("odbc:tank_server", {.table = "public.trend"}, range));
  ::setenv("MLE_ODBC_PASSWORD", "falsch-0815", 1);
  EXPECT_THAT(ErrorFrom("odbc:tank_server", {.table = "trend"}),
              AllOf(HasSubstr("password authentication failed"),
                    Not(HasSubstr("falsch-0815"))));
}

}  // namespace
}  // namespace mle
