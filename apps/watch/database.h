// The database of the state, SQLite or PostgreSQL: the same statements, errors
// as absl::Status.
//
//   MLE_ASSIGN_OR_RETURN(Database database, Database::Open("watch.sqlite"));
//   MLE_ASSIGN_OR_RETURN(Statement insert,
//                        database.Prepare("INSERT INTO day VALUES (?, ?)"));
//   insert.Bind(1, 20780).BindText(2, "used");
//   MLE_RETURN_IF_ERROR(insert.Run());
//
// Definitions of tables are in SQLite's words; PostgreSQL gets its own types
// for them, and keeps all in the schema mle_watch.

#ifndef APPS_WATCH_DATABASE_H_
#define APPS_WATCH_DATABASE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle::watch {

// Parameters count from 1, columns from 0.
class StatementBackend {
 public:
  virtual ~StatementBackend() = default;

  virtual void Bind(int parameter, std::int64_t value) = 0;
  virtual void Bind(int parameter, double value) = 0;
  virtual void BindText(int parameter, std::string_view value) = 0;
  virtual void BindBytes(int parameter, std::string_view value) = 0;
  virtual absl::StatusOr<bool> Next() = 0;
  virtual std::int64_t Integer(int column) const = 0;
  virtual double Number(int column) const = 0;
  virtual std::string Text(int column) const = 0;
  virtual bool IsNull(int column) const = 0;
  virtual void Reset() = 0;
};

class Statement {
 public:
  explicit Statement(std::unique_ptr<StatementBackend> backend)
      : backend_(std::move(backend)) {}

  // An error is reported by the next Next() or Run(). What is not bound is
  // null.
  Statement& Bind(int parameter, std::int64_t value) {
    backend_->Bind(parameter, value);
    return *this;
  }
  Statement& Bind(int parameter, double value) {
    backend_->Bind(parameter, value);
    return *this;
  }
  Statement& BindText(int parameter, std::string_view value) {
    backend_->BindText(parameter, value);
    return *this;
  }
  Statement& BindBytes(int parameter, std::string_view value) {
    backend_->BindBytes(parameter, value);
    return *this;
  }

  // True with a row.
  absl::StatusOr<bool> Next() { return backend_->Next(); }
  // Null is 0, or empty.
  std::int64_t Integer(int column) const { return backend_->Integer(column); }
  double Number(int column) const { return backend_->Number(column); }
  std::string Text(int column) const { return backend_->Text(column); }
  bool IsNull(int column) const { return backend_->IsNull(column); }

  // To its end; can then be bound and run again.
  absl::Status Run();

 private:
  std::unique_ptr<StatementBackend> backend_;
};

class DatabaseBackend {
 public:
  virtual ~DatabaseBackend() = default;

  virtual absl::Status Execute(const std::string& statements) = 0;
  virtual absl::StatusOr<std::unique_ptr<StatementBackend>> Prepare(
      std::string_view statement) = 0;
  // A transaction that no other writer comes between, as BEGIN.
  virtual const char* Begin() const = 0;
  // The version of the tables, 0 if there are none; called in a transaction
  // that no other connection writes in.
  virtual absl::StatusOr<std::int64_t> Version() = 0;
  virtual absl::Status SetVersion(int version) = 0;
  // SELECT of a number that is another once another connection has written.
  virtual const char* Revision() const = 0;
  // See State::Claim().
  virtual absl::Status Claim(const std::string& /*part*/) {
    return absl::OkStatus();
  }
};

class Database {
 public:
  // postgresql://…, or a file, which is made where there is none: write-ahead
  // log, flushed at every commit, foreign keys on. Errors name it.
  static absl::StatusOr<Database> Open(const std::string& name);

  absl::Status Execute(const std::string& statements) {
    return backend_->Execute(statements);
  }
  absl::StatusOr<Statement> Prepare(std::string_view statement);
  DatabaseBackend& backend() { return *backend_; }

 private:
  explicit Database(std::unique_ptr<DatabaseBackend> backend)
      : backend_(std::move(backend)) {}

  std::unique_ptr<DatabaseBackend> backend_;
};

absl::StatusOr<std::unique_ptr<DatabaseBackend>> OpenSqliteState(
    const std::string& path);
absl::StatusOr<std::unique_ptr<DatabaseBackend>> OpenPostgresqlState(
    const std::string& uri);

// A transaction that is rolled back unless it was committed.
class Transaction {
 public:
  static absl::StatusOr<Transaction> Begin(Database& database);
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();
  absl::Status Commit();

 private:
  explicit Transaction(Database& database) : database_(&database) {}

  Database* database_;  // null once it has ended
};

}  // namespace mle::watch

#endif  // APPS_WATCH_DATABASE_H_
