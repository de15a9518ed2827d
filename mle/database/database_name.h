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

// A URI of PostgreSQL with all that it says as parameters, as libpq reads it,
// "postgresql:///?host=…&user=…", and with `password` if that is not empty.
// InvalidArgument for a URI that has a password in it or cannot be read; it
// does not repeat the URI.
//
// Everything is written by letters, digits and percent signs: SOCI takes what
// it is given apart at blanks, quotes and equals signs.
absl::StatusOr<std::string> PostgresqlParameters(const std::string& uri,
                                                 const std::string& password);

}  // namespace mle

#endif  // MLE_DATABASE_DATABASE_NAME_H_
