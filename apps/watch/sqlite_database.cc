#include <sqlite3.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/watch/database.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

constexpr int kBusyMilliseconds = 10'000;

absl::Status SqliteError(sqlite3* database, int code) {
  const std::string message =
      absl::StrCat("state: ", sqlite3_db_filename(database, "main"), ": ",
                   sqlite3_errmsg(database));
  switch (code & 0xff) {
    case SQLITE_FULL:
    case SQLITE_IOERR:
    case SQLITE_NOMEM:
      return absl::ResourceExhaustedError(message);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return absl::UnavailableError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    default:
      return absl::InternalError(message);
  }
}

struct Finalise {
  void operator()(sqlite3_stmt* statement) const {
    sqlite3_finalize(statement);
  }
};
using Prepared = std::unique_ptr<sqlite3_stmt, Finalise>;

// Parameters count from 1.
int Bind(sqlite3_stmt* statement, int parameter, const Value& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    return sqlite3_bind_int64(statement, parameter, *integer);
  }
  if (const auto* number = std::get_if<double>(&value)) {
    return sqlite3_bind_double(statement, parameter, *number);
  }
  if (const auto* text = std::get_if<std::string>(&value)) {
    return sqlite3_bind_text64(statement, parameter, text->data(), text->size(),
                               SQLITE_STATIC, SQLITE_UTF8);
  }
  if (const auto* bytes = std::get_if<Bytes>(&value)) {
    return sqlite3_bind_blob64(statement, parameter, bytes->bytes.data(),
                               bytes->bytes.size(), SQLITE_STATIC);
  }
  return SQLITE_OK;
}

Value ColumnOf(sqlite3_stmt* statement, int column) {
  const auto bytes = [&] {
    const void* const data = sqlite3_column_blob(statement, column);
    const auto size =
        static_cast<std::size_t>(sqlite3_column_bytes(statement, column));
    return data == nullptr ? std::string()
                           : std::string(static_cast<const char*>(data), size);
  };
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
      return std::int64_t{sqlite3_column_int64(statement, column)};
    case SQLITE_FLOAT:
      return sqlite3_column_double(statement, column);
    case SQLITE_TEXT:
      return bytes();
    case SQLITE_BLOB:
      return Bytes{bytes()};
    default:
      return {};
  }
}

class SqliteDatabase : public Database {
 public:
  explicit SqliteDatabase(sqlite3* database) : database_(database) {}

  absl::StatusOr<Rows> Run(const std::string& statement,
                           const std::vector<Value>& values) override {
    sqlite3_stmt* made = nullptr;
    int code = sqlite3_prepare_v2(database_.get(), statement.c_str(), -1, &made,
                                  nullptr);
    const Prepared prepared(made);
    for (std::size_t i = 0; i < values.size() && code == SQLITE_OK; ++i) {
      code = Bind(made, static_cast<int>(i) + 1, values[i]);
    }
    Rows rows;
    while (code == SQLITE_OK || code == SQLITE_ROW) {
      code = sqlite3_step(made);
      if (code != SQLITE_ROW) break;
      std::vector<Value> row;
      for (int column = 0; column < sqlite3_column_count(made); ++column) {
        row.push_back(ColumnOf(made, column));
      }
      rows.emplace_back(std::move(row));
    }
    if (code != SQLITE_DONE) return SqliteError(database_.get(), code);
    return rows;
  }
  absl::Status Execute(const std::string& statements) override {
    const int code = sqlite3_exec(database_.get(), statements.c_str(), nullptr,
                                  nullptr, nullptr);
    return code == SQLITE_OK ? absl::OkStatus()
                             : SqliteError(database_.get(), code);
  }
  const char* Begin() const override { return "BEGIN IMMEDIATE"; }
  absl::StatusOr<std::int64_t> Version() override {
    MLE_ASSIGN_OR_RETURN(const Rows rows, Run("PRAGMA user_version", {}));
    return rows.at(0).Integer(0);
  }
  // FailedPrecondition where there are tables that are not of a state.
  absl::Status CheckOwner() {
    MLE_ASSIGN_OR_RETURN(const std::int64_t version, Version());
    MLE_ASSIGN_OR_RETURN(const Rows tables,
                         Run("SELECT COUNT(*) FROM sqlite_schema", {}));
    if (version != 0 || tables.at(0).Integer(0) == 0) return absl::OkStatus();
    return absl::FailedPreconditionError(absl::StrCat(
        "state: ", sqlite3_db_filename(database_.get(), "main"),
        ": it is an SQLite file of another program; name one that is not there "
        "yet"));
  }
  absl::Status SetVersion(int version) override {
    return Execute(absl::StrCat("PRAGMA user_version = ", version));
  }
  const char* Revision() const override { return "PRAGMA data_version"; }

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
  };

  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> OpenSqliteState(
    const std::string& path) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(
      path.c_str(), &opened,
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX,
      nullptr);
  auto database = std::make_unique<SqliteDatabase>(opened);
  if (code != SQLITE_OK) {
    return InvalidArgument(
        "state: ", path, ": ",
        opened == nullptr ? "out of memory" : sqlite3_errmsg(opened));
  }
  sqlite3_busy_timeout(opened, kBusyMilliseconds);
  // The schema of a damaged or replaced file is not trusted.
  MLE_RETURN_IF_ERROR(database->Execute(
      "PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON"));
  MLE_RETURN_IF_ERROR(database->CheckOwner());
  // The page size is that of a new file: rows of scores leave less of larger
  // pages empty.
  MLE_RETURN_IF_ERROR(
      database->Execute("PRAGMA page_size = 8192; PRAGMA journal_mode = WAL; "
                        "PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON"));
  return database;
}

}  // namespace mle::watch
