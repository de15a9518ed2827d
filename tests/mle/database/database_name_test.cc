// Names of databases, and that no password is in them; their values as fields.

#include "mle/database/database_name.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/row_source.h"
#include "mle/database/record_sources.h"
#include "mle/database/sql_backend.h"
#include "mle/database/table_query.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(DatabaseNameTest, DatabasesAndFilesAreToldApart) {
  for (const char* const name :
       {"postgresql:///plant", "postgres://u@h/plant", "sqlite:a.db",
        "SQLite:a.db", "odbc:plant", "mysql://h/plant", "jdbc:x"}) {
    EXPECT_TRUE(IsDatabase(name)) << name;
  }
  for (const char* const name : {"a.csv", "-", "/data/a:b.csv", "C:/a.csv",
                                 "sqlite", "://x", "", "a b://c"}) {
    EXPECT_FALSE(IsDatabase(name)) << name;
  }
}

TEST(DatabaseNameTest, PasswordsAreRefusedAndNotRepeated) {
  for (const char* const name :
       {"postgresql://reader:geheim@host/plant",
        "postgres://reader:geheim@/plant",
        "postgresql://:geheim@host",
        "POSTGRESQL://reader:geheim@host/plant",
        "postgresql://reader:gehe@im/x@host/plant",
        "postgresql://host/plant?password=geheim",
        "postgresql://host/plant?user=r&pass%77ord=geheim",
        "postgresql://host/plant?sslpassword=geheim",
        "odbc:DSN=plant;UID=r;PWD=geheim",
        "odbc:plant; pwd = geheim",
        "odbc:Driver=x;Password={geheim}",
        "odbc:Driver=x;{PWD}=geheim",
        "odbc:Driver=x;Auth_AccessToken=geheim",
        "odbc:a;Token=geheim",
        "odbc:a;Auth_Client_Secret=geheim",
        "odbc:a;PRIV_KEY_FILE_PWD=geheim",
        "odbc:a;passcode=geheim",
        "odbc:a;APIKey=geheim",
        "odbc:a;SSLKeyPassword=geheim",
        "odbc:a;ProxyPwd=geheim",
        "odbc://reader:geheim@host/plant",
        "postgresql://r%3Ageheim@host/x",
        "sqlite://reader:geheim@x",
        "sqlite:a.db?key=geheim",
        "sqlite:a.db?mode=ro&passphrase=geheim"}) {
    const auto parsed = ParseDatabaseName(name);
    ASSERT_FALSE(parsed.ok()) << name;
    const std::string message(parsed.status().message());
    EXPECT_THAT(message, HasSubstr("has a password in it")) << name;
    EXPECT_THAT(message, Not(HasSubstr("geheim"))) << name;
    EXPECT_THAT(message, Not(HasSubstr("gehe"))) << name;
    // Nor is it let through with the others.
    EXPECT_FALSE(RecordSources({name}, {.table = "t"}, {}).ok()) << name;
  }
}

TEST(DatabaseNameTest, OtherNamesAreRefusedWithWhatIsRight) {
  for (const char* const name :
       {"mysql://reader:geheim@h/plant", "jdbc:sqlserver:geheim",
        "postgresql://host:geheim/plant", "postgresql://[geheim",
        "postgresql:///?geheim"}) {
    const auto parsed = ParseDatabaseName(name);
    ASSERT_FALSE(parsed.ok()) << name;
    EXPECT_THAT(std::string(parsed.status().message()),
                Not(HasSubstr("geheim")));
    EXPECT_THAT(std::string(parsed.status().message()),
                HasSubstr("postgresql://"));
  }
  EXPECT_FALSE(ParseDatabaseName("sqlite:").ok());
  EXPECT_FALSE(ParseDatabaseName("odbc:").ok());
  EXPECT_THAT(
      std::string(ParseDatabaseName("odbc://geheim").status().message()),
      AllOf(HasSubstr("must be odbc:NAME"), Not(HasSubstr("geheim"))));
  EXPECT_FALSE(ParseDatabaseName("sqlite:a\"b.db").ok());
}

TEST(DatabaseNameTest, UrisKeepWhatTheySay) {
  const auto uri = PostgresqlParameters(
      "postgresql://a%20b@localhost:5433/pl%22ant?sslmode=require", "p' \"=w");
  ASSERT_TRUE(uri.ok()) << uri.status();
  EXPECT_THAT(*uri, HasSubstr("user=a%20b&"));
  EXPECT_THAT(*uri, HasSubstr("host=localhost&port=5433"));
  EXPECT_THAT(*uri, HasSubstr("dbname=pl%22ant"));
  EXPECT_THAT(*uri, HasSubstr("sslmode=require"));
  EXPECT_THAT(*uri, HasSubstr("password=p%27%20%22%3dw"));
  EXPECT_EQ(uri->find(' '), std::string::npos);
}

TEST(DatabaseNameTest, OptionsMustFit) {
  const auto refused = [](const DatabaseOptions& options) {
    return std::string(
        RecordSources({"sqlite:a.db"}, options, {}).status().message());
  };
  EXPECT_THAT(refused({}), HasSubstr("either table or query"));
  EXPECT_THAT(refused({.query = "SELECT 1", .table = "t"}),
              HasSubstr("not both"));
  EXPECT_THAT(refused({.query = "SELECT 1", .columns = {"a"}}),
              HasSubstr("columns are those of a table"));
  EXPECT_THAT(
      std::string(
          RecordSources({"a.csv"}, {.table = "t"}, {}).status().message()),
      HasSubstr("none is named"));
}

TEST(DatabaseNameTest, PartsOfTables) {
  EXPECT_THAT(*PartsOfTable("trend"), ElementsAre("trend"));
  EXPECT_THAT(*PartsOfTable("a.b.c d"), ElementsAre("a", "b", "c d"));
  EXPECT_THAT(*PartsOfTable("\"a.b\".\"c\"\"d\""), ElementsAre("a.b", "c\"d"));
  EXPECT_THAT(*PartsOfTable("t; DROP TABLE t"), ElementsAre("t; DROP TABLE t"));
  for (const char* const table :
       {"", ".", "a.", ".a", "\"a", "\"a\"b", "a\"b\"", "\"\"", "a..b"}) {
    EXPECT_FALSE(PartsOfTable(table).ok()) << table;
  }
}

TEST(SqlValues, NumbersKeepTheirBits) {
  std::mt19937_64 random(2);
  std::vector<double> numbers = {
      0.0, -0.0, 0.1, 1e300, 5e-324, std::numeric_limits<double>::max()};
  for (int k = 0; k < 1000; ++k) {
    const auto number = std::bit_cast<double>(random());
    if (std::isfinite(number)) numbers.push_back(number);
  }
  for (const double number : numbers) {
    RowBlock rows;
    AddNumber(number, rows);
    std::vector<std::string_view> fields;
    rows.Get(0, 1, fields);
    double again = 0.0;
    ASSERT_TRUE(ReadCsvNumber(fields[0], again)) << fields[0];
    EXPECT_EQ(std::bit_cast<std::uint64_t>(again),
              std::bit_cast<std::uint64_t>(number));
  }
}

TEST(SqlValues, TextsStayInOneLine) {
  RowBlock rows;
  AddText("a,\"b\" ", rows);
  AddText(std::string_view("1\n2\r\t\0\x7F", 7), rows);
  AddInteger(std::numeric_limits<std::int64_t>::min(), rows);
  std::vector<std::string_view> fields;
  rows.Get(0, 3, fields);
  EXPECT_THAT(fields, ElementsAre("a,\"b\" ", "1 2  \\x00\\x7f",
                                  "-9223372036854775808"));
}

}  // namespace
}  // namespace mle
