// A session with a database, which only reads, as statuses. SOCI throws, and
// this is where that ends. Internal to mle/database.
//
//   MLE_ASSIGN_OR_RETURN(std::unique_ptr<DatabaseSession> session,
//                        DatabaseSession::Connect(name, {}, ask_password));
//   MLE_ASSIGN_OR_RETURN(columns, session->Start("SELECT time, y FROM trend"));
//   MLE_ASSIGN_OR_RETURN(const int rows, session->Read(5000, text));
//
// Errors have the text of the database in one line, without any password:
// Unavailable for one that cannot be reached or has gone, PermissionDenied,
// InvalidArgument for all others.

#ifndef MLE_DATABASE_DATABASE_SESSION_H_
#define MLE_DATABASE_DATABASE_SESSION_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/row_source.h"
#include "mle/database/database_name.h"
#include "mle/database/sql_backend.h"

namespace mle {

using AskPassword =
    std::function<std::optional<std::string>(const std::string& prompt)>;

class DatabaseSession {
 public:
  // `ask` may be empty.
  static absl::StatusOr<std::unique_ptr<DatabaseSession>> Connect(
      const DatabaseName& name, const SqlLimits& limits,
      const AskPassword& ask);

  // As of SqlBackend.
  absl::StatusOr<std::vector<SqlColumn>> Start(const std::string& query);
  absl::StatusOr<int> Read(int most, RowBlock& rows);
  // Empty where the database does not say.
  std::vector<std::string> Tables();
  absl::StatusOr<std::string> Quote(const std::string& name) const;
  absl::StatusOr<std::string> Order(const std::string& table,
                                    const std::string& column);
  absl::StatusOr<bool> HasTextDates(const std::string& table,
                                    const std::string& column);
  std::string DateLiteral(const std::string& date) const {
    return backend_->DateLiteral(date);
  }

 private:
  DatabaseSession() = default;

  // Runs `call`; an exception that it throws becomes a status without secrets.
  absl::Status Guard(const std::function<void()>& call) const;
  absl::Status Open(const DatabaseName& name, const std::string& password);

  std::unique_ptr<SqlBackend> backend_;
  SqlLimits limits_;
  std::int64_t rows_ = 0;             // since the start of a query
  std::vector<std::string> secrets_;  // that no message may have
};

}  // namespace mle

#endif  // MLE_DATABASE_DATABASE_SESSION_H_
