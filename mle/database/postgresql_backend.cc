// PostgreSQL, by a cursor: libpq would hold all rows of a query otherwise.
//
// SOCI has session, statements and errors. Values are taken from its results as
// the server writes them, since SOCI's own types have no fractions of seconds.

#include <libpq-fe.h>
#include <soci/postgresql/soci-postgresql.h>
#include <soci/soci.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/database/sql_backend.h"

namespace mle {
namespace {

// Types of dates in pg_type: date, timestamp, timestamptz.
constexpr Oid kDate = 1082;
constexpr Oid kTimestamp = 1114;
constexpr Oid kTimestampWithZone = 1184;
// Approximate size of the rows that are fetched at once: values may be long.
constexpr std::size_t kBlockBytes = std::size_t{16} << 20;
constexpr int kFirstRows = 64;
constexpr int kFactor = 4;

class PostgresqlBackend : public SqlBackend {
 public:
  PostgresqlBackend(const std::string& uri, const SqlLimits& limits)
      : limits_(limits), session_(soci::postgresql, uri) {
    session_ << absl::StrCat("SET statement_timeout = '", limits.max_wait_s,
                             "s'");
    // Dates in one form and, those with a zone, in UTC.
    for (const char* const setting :
         {"SET default_transaction_read_only = on", "SET DateStyle = ISO",
          "SET TimeZone = 'UTC'", "SET client_encoding = 'UTF8'"}) {
      session_ << setting;
    }
  }

  std::vector<SqlColumn> Start(const std::string& query) override;
  int Read(int most, RowBlock& rows) override;
  std::vector<std::string> Tables() override;
  std::string DateLiteral(const std::string& date) const override {
    return absl::StrCat("timestamp '", date, "'");
  }

 private:
  // Prepared, which takes one command alone.
  void Execute(const std::string& command) {
    soci::statement statement = (session_.prepare << command);
    statement.execute();
  }
  void Begin();
  void Fetch(int rows);
  const PGresult* Result() {
    return static_cast<soci::postgresql_statement_backend*>(
               fetch_->get_backend())
        ->result_;
  }

  const SqlLimits limits_;
  soci::session session_;
  bool has_begun_ = false;
  std::optional<soci::statement> fetch_;
  int fetch_rows_ = -1;
  int next_rows_ = kFirstRows;
};

// All cursors see the database as it is now.
void PostgresqlBackend::Begin() {
  fetch_.reset();
  fetch_rows_ = -1;
  if (has_begun_) {
    session_ << "CLOSE ALL";
    return;
  }
  session_ << "BEGIN TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY";
  has_begun_ = true;
}

void PostgresqlBackend::Fetch(int rows) {
  if (fetch_rows_ != rows) {
    fetch_.emplace((session_.prepare
                    << absl::StrCat("FETCH FORWARD ", rows, " FROM mle_rows")));
    fetch_rows_ = rows;
  }
  fetch_->execute();
}

std::vector<SqlColumn> PostgresqlBackend::Start(const std::string& query) {
  Begin();
  Execute(absl::StrCat("DECLARE mle_rows NO SCROLL CURSOR FOR ", query));
  Fetch(0);
  std::vector<SqlColumn> columns;
  const PGresult* const result = Result();
  for (int c = 0; c < PQnfields(result); ++c) {
    const Oid type = PQftype(result, c);
    columns.push_back({PQfname(result, c), type == kDate ||
                                               type == kTimestamp ||
                                               type == kTimestampWithZone});
  }
  return columns;
}

int PostgresqlBackend::Read(int most, RowBlock& rows) {
  Fetch(std::min(most, next_rows_));
  const PGresult* const result = Result();
  const int count = PQntuples(result);
  const int columns = PQnfields(result);
  const std::size_t before = rows.bytes();
  for (int r = 0; r < count; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (PQgetisnull(result, r, c) != 0) {
        rows.Add("");
      } else {
        AddLimitedText({PQgetvalue(result, r, c),
                        static_cast<std::size_t>(PQgetlength(result, r, c))},
                       limits_, rows);
      }
    }
  }
  const std::size_t bytes = rows.bytes() - before;
  if (bytes > kBlockBytes) {
    next_rows_ = std::max(1, fetch_rows_ / kFactor);
  } else if (kFactor * bytes < kBlockBytes && next_rows_ < most) {
    next_rows_ *= kFactor;
  }
  return count;
}

std::vector<std::string> PostgresqlBackend::Tables() {
  // The error before has ended the transaction.
  fetch_.reset();
  fetch_rows_ = -1;
  if (has_begun_) session_ << "ROLLBACK";
  has_begun_ = false;
  std::vector<std::string> names(1000);
  session_ << "SELECT CASE WHEN table_schema = ANY (current_schemas(false)) "
              "THEN '' ELSE table_schema || '.' END || table_name "
              "FROM information_schema.tables WHERE table_schema NOT IN "
              "('pg_catalog', 'information_schema') ORDER BY 1 LIMIT 1000",
      soci::into(names);
  return names;
}

}  // namespace

std::unique_ptr<SqlBackend> OpenPostgresql(const std::string& uri,
                                           const SqlLimits& limits) {
  return std::make_unique<PostgresqlBackend>(uri, limits);
}

}  // namespace mle
