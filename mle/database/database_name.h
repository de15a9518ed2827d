// Names of databases: their kind, and that no password is in them. Internal to
// mle/database.

#ifndef MLE_DATABASE_DATABASE_NAME_H_
#define MLE_DATABASE_DATABASE_NAME_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace mle {

enum class DatabaseKind { kPostgresql, kSqlite, kOdbc };

struct DatabaseName {
  DatabaseKind kind = DatabaseKind::kSqlite;
  std::string text;   // as it was given
  std::string place;  // URI, path or data source
};

// InvalidArgument for a password, which is not repeated, and for a database of
// another kind.
absl::StatusOr<DatabaseName> ParseDatabaseName(std::string_view text);

// "//user:word@host", also where a library would not read it so.
bool HasPasswordOfUser(std::string_view uri);

// That a name has a password in it, and where it should be instead.
absl::Status PasswordError(std::string_view kind, std::string_view remedy);

}  // namespace mle

#endif  // MLE_DATABASE_DATABASE_NAME_H_
