// The database of the state, SQLite or PostgreSQL: the same statements, errors
// as absl::Status.
//
//   MLE_ASSIGN_OR_RETURN(auto database, Database::Open("watch.sqlite"));
//   MLE_RETURN_IF_ERROR(
//       database->Run("INSERT INTO day VALUES (?, ?)", {20780, "used"})
//           .status());
//
// Definitions of tables are in SQLite's words; PostgreSQL gets its own types
// for them, and keeps all in the schema mle_watch.

#ifndef APPS_WATCH_DATABASE_H_
#define APPS_WATCH_DATABASE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle::watch {

struct Bytes {
  std::string bytes;
};
// The first is null.
using Value =
    std::variant<std::monostate, std::int64_t, double, std::string, Bytes>;

// One row of a result; columns count from 0.
class Row {
 public:
  explicit Row(std::vector<Value> values) : values_(std::move(values)) {}

  // A value that is null or of another type reads as 0 or empty; a whole number
  // reads as a Number(), too.
  std::int64_t Integer(std::size_t column) const;
  double Number(std::size_t column) const;
  std::string Text(std::size_t column) const;  // bytes, too
  bool IsNull(std::size_t column) const;

 private:
  std::vector<Value> values_;
};
using Rows = std::vector<Row>;

class Database {
 public:
  // postgresql://…, or a file, which is made where there is none: write-ahead
  // log, flushed at every commit, foreign keys on. Errors name it.
  static absl::StatusOr<std::unique_ptr<Database>> Open(
      const std::string& name);
  virtual ~Database() = default;

  // One statement; each "?" in it stands for the next of `values`.
  virtual absl::StatusOr<Rows> Run(const std::string& statement,
                                   const std::vector<Value>& values) = 0;
  // Several, without values and results.
  virtual absl::Status Execute(const std::string& statements) = 0;
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

absl::StatusOr<std::unique_ptr<Database>> OpenSqliteState(
    const std::string& path);
absl::StatusOr<std::unique_ptr<Database>> OpenPostgresqlState(
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
