#include <sqlite3.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>

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

class SqliteStatement : public StatementBackend {
 public:
  explicit SqliteStatement(sqlite3_stmt* statement) : statement_(statement) {}

  void Bind(int parameter, std::int64_t value) override {
    Note(sqlite3_bind_int64(statement_.get(), parameter, value));
  }
  void Bind(int parameter, double value) override {
    Note(sqlite3_bind_double(statement_.get(), parameter, value));
  }
  void BindText(int parameter, std::string_view value) override {
    Note(sqlite3_bind_text64(statement_.get(), parameter, value.data(),
                             value.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  }
  void BindBytes(int parameter, std::string_view value) override {
    Note(sqlite3_bind_blob64(statement_.get(), parameter, value.data(),
                             value.size(), SQLITE_TRANSIENT));
  }
  absl::StatusOr<bool> Next() override {
    sqlite3* const database = sqlite3_db_handle(statement_.get());
    if (bound_ != SQLITE_OK) return SqliteError(database, bound_);
    const int code = sqlite3_step(statement_.get());
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return SqliteError(database, code);
  }
  std::int64_t Integer(int column) const override {
    return sqlite3_column_int64(statement_.get(), column);
  }
  double Number(int column) const override {
    return sqlite3_column_double(statement_.get(), column);
  }
  std::string Text(int column) const override {
    const void* const bytes = sqlite3_column_blob(statement_.get(), column);
    const int size = sqlite3_column_bytes(statement_.get(), column);
    return bytes == nullptr ? std::string()
                            : std::string(static_cast<const char*>(bytes),
                                          static_cast<std::size_t>(size));
  }
  bool IsNull(int column) const override {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
  }
  void Reset() override {
    sqlite3_reset(statement_.get());
    sqlite3_clear_bindings(statement_.get());
    bound_ = SQLITE_OK;
  }

 private:
  struct Finalise {
    void operator()(sqlite3_stmt* statement) const {
      sqlite3_finalize(statement);
    }
  };
  void Note(int code) {
    if (bound_ == SQLITE_OK) bound_ = code;
  }

  std::unique_ptr<sqlite3_stmt, Finalise> statement_;
  int bound_ = SQLITE_OK;  // the first error of Bind()
};

class SqliteDatabase : public DatabaseBackend {
 public:
  explicit SqliteDatabase(sqlite3* database) : database_(database) {}

  absl::Status Execute(const std::string& statements) override {
    const int code = sqlite3_exec(database_.get(), statements.c_str(), nullptr,
                                  nullptr, nullptr);
    return code == SQLITE_OK ? absl::OkStatus()
                             : SqliteError(database_.get(), code);
  }
  absl::StatusOr<std::unique_ptr<StatementBackend>> Prepare(
      std::string_view statement) override {
    sqlite3_stmt* prepared = nullptr;
    const int code = sqlite3_prepare_v2(database_.get(), statement.data(),
                                        static_cast<int>(statement.size()),
                                        &prepared, nullptr);
    if (code != SQLITE_OK) return SqliteError(database_.get(), code);
    return std::make_unique<SqliteStatement>(prepared);
  }
  const char* Begin() const override { return "BEGIN IMMEDIATE"; }
  absl::StatusOr<std::int64_t> Version() override {
    MLE_ASSIGN_OR_RETURN(const auto select, Prepare("PRAGMA user_version"));
    MLE_RETURN_IF_ERROR(select->Next().status());
    return select->Integer(0);
  }
  // FailedPrecondition where there are tables that are not of a state.
  absl::Status CheckOwner() {
    MLE_ASSIGN_OR_RETURN(const std::int64_t version, Version());
    MLE_ASSIGN_OR_RETURN(const auto tables,
                         Prepare("SELECT COUNT(*) FROM sqlite_schema"));
    MLE_RETURN_IF_ERROR(tables->Next().status());
    if (version != 0 || tables->Integer(0) == 0) return absl::OkStatus();
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

absl::StatusOr<std::unique_ptr<DatabaseBackend>> OpenSqliteState(
    const std::string& path) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(
      path.c_str(), &opened,
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX,
      nullptr);
  auto database = std::make_unique<SqliteDatabase>(opened);
  if (code != SQLITE_OK) {
    return absl::InvalidArgumentError(absl::StrCat(
        "state: ", path, ": ",
        opened == nullptr ? "out of memory" : sqlite3_errmsg(opened)));
  }
  sqlite3_busy_timeout(opened, kBusyMilliseconds);
  // What a damaged or an exchanged file says of itself is not trusted.
  MLE_RETURN_IF_ERROR(database->Execute(
      "PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON"));
  MLE_RETURN_IF_ERROR(database->CheckOwner());
  // Of a new file: rows of scores leave less of larger pages empty.
  MLE_RETURN_IF_ERROR(
      database->Execute("PRAGMA page_size = 8192; PRAGMA journal_mode = WAL; "
                        "PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON"));
  return database;
}

}  // namespace mle::watch
