// SQLite, a file opened for reading only, row by row.
//
// SOCI has session, statements and errors. Values are taken from its statements
// with the type that each of them has: SOCI goes by the declared type of the
// column, which SQLite does not, and as text numbers have 15 digits.

#include <soci/soci.h>
#include <soci/sqlite3/soci-sqlite3.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/database/sql_backend.h"

namespace mle {
namespace {

// Another program may be writing.
constexpr int kTimeoutSeconds = 10;
// Steps of SQLite's machine between two looks at the clock, some milliseconds.
constexpr int kStepsOfLook = 100'000;

class SqliteBackend : public SqlBackend {
 public:
  SqliteBackend(const std::string& path, const SqlLimits& limits)
      : max_wait_(limits.max_wait_s),
        session_(soci::sqlite3,
                 absl::StrCat("db=\"", path,
                              "\" readonly=true timeout=", kTimeoutSeconds)) {
    sqlite_api::sqlite3_limit(Connection(), SQLITE_LIMIT_LENGTH,
                              static_cast<int>(limits.max_value_bytes));
    sqlite_api::sqlite3_progress_handler(Connection(), kStepsOfLook, &IsLate,
                                         this);
  }

  std::vector<SqlColumn> Start(const std::string& query) override;
  int Read(int most, RowBlock& rows) override;
  std::vector<std::string> Tables() override;
  std::string Order(const std::string& table,
                    const std::string& column) override;
  bool HasTextDates(const std::string& table,
                    const std::string& column) override;
  std::string DateLiteral(const std::string& date) const override {
    return absl::StrCat("'", date, "'");
  }

 private:
  sqlite_api::sqlite3* Connection() {
    return static_cast<soci::sqlite3_session_backend*>(session_.get_backend())
        ->conn_;
  }
  static int IsLate(void* backend) {
    const auto& self = *static_cast<const SqliteBackend*>(backend);
    return std::chrono::steady_clock::now() > self.end_ ? 1 : 0;
  }
  // Throws where `step` takes too long.
  template <typename Step>
  auto InTime(const Step& step);
  void CheckIsOne(const std::string& query);
  void AddValue(int column, RowBlock& rows) const;

  const std::chrono::seconds max_wait_;
  std::chrono::steady_clock::time_point end_ =
      std::chrono::steady_clock::time_point::max();
  soci::session session_;
  bool has_begun_ = false;
  std::optional<soci::statement> statement_;
  soci::sqlite3_statement_backend* rows_ = nullptr;  // of the statement
  bool has_row_ = false;
};

template <typename Step>
auto SqliteBackend::InTime(const Step& step) {
  end_ = std::chrono::steady_clock::now() + max_wait_;
  try {
    return step();
  } catch (const soci::soci_error&) {
    if (IsLate(this) == 0) throw;
    throw soci::soci_error(
        absl::StrCat("no rows came for ", max_wait_.count(),
                     " s, the limit: does its view or query end?"));
  }
}

// SQLite reads one statement, and passes over what follows it.
void SqliteBackend::CheckIsOne(const std::string& query) {
  const char* rest = query.c_str();
  for (int statements = 0; *rest != '\0';) {
    sqlite_api::sqlite3_stmt* statement = nullptr;
    const int result = sqlite_api::sqlite3_prepare_v2(Connection(), rest, -1,
                                                      &statement, &rest);
    const bool is_blank = result == SQLITE_OK && statement == nullptr;
    sqlite_api::sqlite3_finalize(statement);
    if (!is_blank && statements++ > 0) {
      throw soci::soci_error(
          "a query is one statement, and more follows its semicolon");
    }
    if (result != SQLITE_OK) return;  // which is said where it is prepared
  }
}

std::vector<SqlColumn> SqliteBackend::Start(const std::string& query) {
  CheckIsOne(query);
  // All statements see the database as it is now.
  if (!has_begun_) session_.begin();
  has_begun_ = true;
  rows_ = nullptr;
  statement_.emplace(session_);
  statement_->alloc();
  statement_->prepare(query);
  rows_ =
      static_cast<soci::sqlite3_statement_backend*>(statement_->get_backend());
  std::vector<SqlColumn> columns;
  for (int c = 0; c < sqlite_api::sqlite3_column_count(rows_->stmt_); ++c) {
    columns.push_back({sqlite_api::sqlite3_column_name(rows_->stmt_, c)});
  }
  has_row_ = InTime([&] {
    return rows_->execute(1) == soci::details::statement_backend::ef_success;
  });
  return columns;
}

void SqliteBackend::AddValue(int column, RowBlock& rows) const {
  sqlite_api::sqlite3_stmt* const row = rows_->stmt_;
  switch (sqlite_api::sqlite3_column_type(row, column)) {
    case SQLITE_NULL:
      rows.Add("");
      return;
    case SQLITE_INTEGER:
      AddInteger(sqlite_api::sqlite3_column_int64(row, column), rows);
      return;
    case SQLITE_FLOAT:
      AddNumber(sqlite_api::sqlite3_column_double(row, column), rows);
      return;
    default: {
      const void* const bytes = sqlite_api::sqlite3_column_blob(row, column);
      const int size = sqlite_api::sqlite3_column_bytes(row, column);
      AddText({static_cast<const char*>(bytes), static_cast<std::size_t>(size)},
              rows);
    }
  }
}

int SqliteBackend::Read(int most, RowBlock& rows) {
  return InTime([&] {
    int count = 0;
    while (has_row_ && count < most) {
      const int columns = sqlite_api::sqlite3_column_count(rows_->stmt_);
      for (int c = 0; c < columns; ++c) AddValue(c, rows);
      ++count;
      has_row_ =
          rows_->fetch(1) == soci::details::statement_backend::ef_success;
    }
    return count;
  });
}

std::vector<std::string> SqliteBackend::Tables() {
  std::vector<std::string> names(1000);
  session_ << "SELECT name FROM sqlite_master WHERE type IN ('table', 'view') "
              "ORDER BY name LIMIT 1000",
      soci::into(names);
  return names;
}

// Numbers are text where a CSV file was imported, and 101 is then before 11; so
// is the first of April before the fourth of March unless the year stands
// first.
std::string SqliteBackend::Order(const std::string& table,
                                 const std::string& column) {
  std::string kind;
  const auto read = [&] {
    session_ << "SELECT CASE WHEN typeof(" << column
             << ") <> 'text' THEN 'other' WHEN " << column
             << " GLOB '[0-9][0-9][0-9][0-9][-/.][0-9]*[0-9]:[0-9]*' THEN "
                "'other' WHEN "
             << column << " NOT GLOB '*[^0-9.eE+-]*' AND " << column
             << " NOT GLOB '*[0-9]-*' THEN 'number' ELSE 'date' END FROM "
             << table << " LIMIT 1",
        soci::into(kind);
  };
  InTime(read);
  if (kind == "date") return "";
  return kind == "number" ? absl::StrCat("CAST(", column, " AS REAL)") : column;
}

bool SqliteBackend::HasTextDates(const std::string& table,
                                 const std::string& column) {
  int dates = 0;
  const auto read = [&] {
    session_ << "SELECT COALESCE((SELECT typeof(" << column << ") = 'text' AND "
             << column
             << " GLOB '[0-9][0-9][0-9][0-9]-[0-9][0-9]-[0-9][0-9]*' FROM "
             << table << " LIMIT 1), 0)",
        soci::into(dates);
  };
  InTime(read);
  return dates != 0;
}

}  // namespace

std::unique_ptr<SqlBackend> OpenSqlite(const std::string& path,
                                       const SqlLimits& limits) {
  return std::make_unique<SqliteBackend>(path, limits);
}

}  // namespace mle
