// A SQLite database, errors as absl::Status.
//
//   MLE_ASSIGN_OR_RETURN(Database database, Database::Open("watch.sqlite"));
//   MLE_ASSIGN_OR_RETURN(Statement insert,
//                        database.Prepare("INSERT INTO day VALUES (?, ?)"));
//   insert.Bind(1, 20780).Bind(2, "used");
//   MLE_RETURN_IF_ERROR(insert.Run());

#ifndef APPS_WATCH_DATABASE_H_
#define APPS_WATCH_DATABASE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

struct sqlite3;
struct sqlite3_stmt;

namespace mle::watch {

class Statement {
 public:
  // Parameters count from 1; an error is reported by the next Next() or Run().
  Statement& Bind(int parameter, std::int64_t value);
  Statement& Bind(int parameter, double value);
  Statement& BindText(int parameter, std::string_view value);
  Statement& BindBytes(int parameter, std::string_view value);

  // True with a row; columns count from 0.
  absl::StatusOr<bool> Next();
  std::int64_t Integer(int column) const;
  double Number(int column) const;
  std::string Text(int column) const;  // also bytes
  bool IsNull(int column) const;

  // To its end; can then be bound and run again.
  absl::Status Run();

 private:
  friend class Database;
  struct Finalise {
    void operator()(sqlite3_stmt* statement) const;
  };
  explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}

  std::unique_ptr<sqlite3_stmt, Finalise> statement_;
  int bound_ = 0;  // the first error of Bind()
};

class Database {
 public:
  // Makes the file where there is none: write-ahead log, flushed at every
  // commit, foreign keys on. Errors name the file.
  static absl::StatusOr<Database> Open(const std::string& path);

  absl::Status Execute(const std::string& statements);
  absl::StatusOr<Statement> Prepare(std::string_view statement);
  std::int64_t last_row() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  explicit Database(sqlite3* database) : database_(database) {}

  std::unique_ptr<sqlite3, Close> database_;
};

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
